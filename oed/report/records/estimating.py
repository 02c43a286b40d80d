"""What `oed identify` and `oed feasible` write."""

from __future__ import annotations

from typing import Any

from msgspec import field

from oed.report.records.checking import CauseRecord
from oed.report.records.record import ByRole, Matrix, Number, Numbers, Record, ResultRecord, Row


class GapsRecord(Record, frozen=True, kw_only=True):
    """Pauses of one recording's log."""

    gaps: int
    longest_s: float
    total_s: float


class TotalMassRecord(Record, frozen=True, kw_only=True):
    """Mass of all that moves [kg], in the robot's file and as identified where torques tell it."""

    file: Number
    is_in_torque: bool
    value: Number
    interval: Numbers | None


class EstimatedRecord(Record, frozen=True, kw_only=True):
    """A parameter that the data determine; `file` is the robot file's value of the same combination."""

    name: str
    expression: str
    unit: str
    value: Number
    std: Number
    interval95: Numbers
    file: Number


class ConditionRecord(Record, frozen=True, kw_only=True):
    """cond Lambda, log10 det Lambda and the number of rows that they are of."""

    J_k: Number
    J_d_log10: Number
    rows: int


class PredictionRecord(Record, frozen=True, kw_only=True):
    """All columns that predict torque."""

    names: list[str]
    values: Numbers
    covariance: Matrix


class ProcessingRecord(Record, frozen=True, kw_only=True):
    """How signals were processed: rates and cut-off in Hz, trim in s."""

    rate: float
    model_rate: float
    cutoff: float
    decimation: int
    trim: float
    velocity: str
    reasons: list[str]


class SettingsRecord(Record, frozen=True, kw_only=True):
    """Effects of the model, the processing, and what the command was told."""

    model: list[str]
    processing: ProcessingRecord
    configuration: dict[str, Any]


class BaseParametersRecord(Record, frozen=True, kw_only=True):
    """How many there are, and what is to be said of that."""

    count: int
    note: str


class EstimateRecord(ResultRecord, frozen=True, kw_only=True):
    """estimate.json of `oed identify`."""

    data: str
    joints: list[str]
    samples: dict[str, int]
    gaps: dict[str, GapsRecord]
    data_notes: list[str]
    parameters: list[EstimatedRecord]
    total_mass: TotalMassRecord
    doubts: list[str]
    cause: CauseRecord | None
    unidentifiable: list[str]
    unidentifiable_because: dict[str, str]
    condition: ConditionRecord
    reach: Numbers
    rms: ByRole
    noise_floor: Numbers | None
    relative_rms: ByRole
    overall_relative_rms: dict[str, Number]
    prediction: PredictionRecord
    method: str
    settings: SettingsRecord
    base_parameters: BaseParametersRecord
    date: str
    seed: int | None


class FeasibleParameterRecord(Record, frozen=True, kw_only=True):
    """A parameter of a body that can exist.

    `from_data` is the share that the data decide; where they do not decide, there is no interval.
    """

    name: str
    unit: str
    value: Number
    lower95: Number
    upper95: Number
    from_data: Number
    at_bound: bool
    reference: Number


class AccuracyRecord(Record, frozen=True, kw_only=True):
    """How far the objective is from its optimum, relatively."""

    words: str
    asked_for: Number
    reached: Number
    is_accurate: bool
    feasibility_margin: Number


class OptimalityRecord(Record, frozen=True, kw_only=True):
    """As `oed.estimation.feasible.optimality.Optimality`."""

    primal: Number
    decrement: Number
    gap: Number


class SolverRecord(Record, frozen=True, kw_only=True):
    """Which solver found the estimate, and what another one says."""

    name: str
    attempts: list[str]
    optimality: OptimalityRecord
    second: list[str] | None
    relative_difference: Number
    second_failure: str


class WeightCurveRecord(Record, frozen=True, kw_only=True):
    """Errors held out, by weight of the pull; null where it was not solved."""

    weights: Numbers
    held_out: Numbers
    unsolved: list[str]
    least_squares: Number


class RegularisationRecord(Record, frozen=True, kw_only=True):
    """The pull to reference bodies."""

    kind: str
    weight: Number
    reference: str
    joint_variances: Numbers
    curve: WeightCurveRecord | None


class MassMatrixRecord(Record, frozen=True, kw_only=True):
    """Share of poses in which the mass matrix is positive definite."""

    poses: int
    positive_definite: float
    positive_definite_plain: float


class PlainEstimateRecord(Record, frozen=True, kw_only=True):
    """Whether bodies that can exist have the base parameters of plain least squares."""

    has_feasible_robot: bool | None
    failure: str = ""
    margin: Number = None
    bound: Number = None
    certificate_residual: Number = None
    blamed: list[str] = field(default_factory=list)


class FeasibleRecord(ResultRecord, frozen=True, kw_only=True):
    """estimate.json of `oed feasible`."""

    data: str
    joints: list[str]
    gaps: dict[str, GapsRecord]
    data_notes: list[str]
    doubts: list[str]
    cause: CauseRecord | None
    parameters: list[FeasibleParameterRecord]
    links: list[Row]
    validation: list[Row]
    changes_from_file: list[Row]
    warnings: list[str]
    active: list[str]
    objective: Number
    accuracy: AccuracyRecord
    solver: SolverRecord
    regularisation: RegularisationRecord
    mass_matrix: MassMatrixRecord
    plain_estimate: PlainEstimateRecord
    uncertainty: str
    exports: list[Row]
    configuration: dict[str, Any]
    date: str
    seed: int | None
