"""What `oed calibrate` and `oed export` write."""

from __future__ import annotations

from oed.report.records.diagnosing import ErrorsRecord
from oed.report.records.record import FileRecord, Matrix, Number, Numbers, Record, ResultRecord, Row


class NamedEffectRecord(Record, frozen=True, kw_only=True):
    """An effect that was found; its joint counts from 0."""

    name: str
    joint: int | None


class FollowedRecord(Record, frozen=True, kw_only=True):
    """Errors of a model's simulation after each horizon: of the flange [mm], of joints [rad or m].

    A model whose mass matrix is not positive definite has none, and says so.
    """

    flange_mm: Numbers | None
    joint: Matrix | None
    windows: int
    lost: int
    not_simulated: str | None


class RolloutRecord(Record, frozen=True, kw_only=True):
    """Simulations of the held-out recordings, by model; horizons in s."""

    horizons: Numbers
    models: dict[str, FollowedRecord]


class RefinedErrorsRecord(Record, frozen=True, kw_only=True):
    """Errors of a refined model and of that before, on the recordings of a role."""

    role: str
    horizons: Numbers
    torque_ratio: Number
    flange_mm_before: Numbers
    flange_mm_after: Numbers


class RefinementRecord(FileRecord, frozen=True, kw_only=True):
    """Parameters fitted to simulations; refinement.json. Null where it did not come to a fit."""

    accepted: bool
    reason: str
    errors: list[RefinedErrorsRecord]
    windows: int | None = None
    status: str | None = None
    distance: Number = None
    directions: int | None = None
    allowed: Number = None


class CalibrationRecord(FileRecord, frozen=True, kw_only=True):
    """calibration.json; `without_name` says in words what is unexplained."""

    format: int
    data: str
    verdict: str
    effects: list[NamedEffectRecord]
    unexplained: int
    without_name: list[str]
    rms: ErrorsRecord
    links: list[Row]
    changes_from_file: list[Row]
    warnings: list[str]
    exports: dict[str, list[str]]
    joints: list[str]
    rollout: RolloutRecord | None
    refinement: RefinementRecord | None


class LeftOutRecord(Record, frozen=True, kw_only=True):
    """An effect that a form cannot have."""

    name: str
    reason: str


class ExportedRecord(Record, frozen=True, kw_only=True):
    """What was written of one form."""

    files: list[str]
    use: str
    left_out: list[LeftOutRecord]
    notes: list[str]


class OriginRecord(Record, frozen=True, kw_only=True):
    """Where the numbers come from."""

    command: str
    data: str
    method: str
    date: str
    commit: str | None
    seed: int | None
    versions: dict[str, str]


class ExportRecord(ResultRecord, frozen=True, kw_only=True):
    """export.json."""

    model: str
    origin: OriginRecord
    exports: dict[str, ExportedRecord]
    date: str


class SamplesRecord(FileRecord, frozen=True, kw_only=True):
    """samples.json: each row of `samples` is a model that the data do not tell from the estimate."""

    format: int
    seed: int
    names: list[str]
    units: list[str]
    estimate: Numbers
    samples: Matrix


class BodyRangesRecord(Record, frozen=True, kw_only=True):
    """Range of a body's mass [kg], and of its centre's coordinates [m]."""

    mass: list[Number]
    ipos: Matrix


class RandomisationRecord(FileRecord, frozen=True, kw_only=True):
    """randomisation.json: ranges by body, joint and effect, between `tails` [%]."""

    format: int
    tails: list[float]
    body: dict[str, BodyRangesRecord]
    joint: dict[str, dict[str, Numbers]]
    effect: dict[str, Numbers]
