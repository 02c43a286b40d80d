"""What `oed diagnose` writes."""

from __future__ import annotations

from typing import Literal

import msgspec

from oed.report.records.record import (
    ByRole,
    FileRecord,
    Matrix,
    Number,
    Numbers,
    Record,
    ResultRecord,
)


class EffectParameterRecord(Record, frozen=True, kw_only=True):
    """A parameter of an effect; a note says where the recordings tell no deviation."""

    value: Number
    std: Number
    unit: str
    note: str = ""


class AlternativeRecord(Record, frozen=True, kw_only=True):
    """What else an effect could be, in `words`; `same` gives the same torque on these recordings."""

    name: str
    joint: int | None
    term: str
    probability: Number
    contender: bool
    same: bool = False
    words: str = ""


class FoundEffectRecord(Record, frozen=True, kw_only=True):
    """An effect that the model lacked; log evidence and gain in nats, joints counted from 0."""

    name: str
    joint: int | None
    probability: Number
    log_evidence: Number
    held_out_gain: Number
    parameters: dict[str, EffectParameterRecord]
    alternatives: list[AlternativeRecord]


class UnexplainedRecord(Record, frozen=True, kw_only=True):
    """What is left and has no name: the term that describes it, and the same in `words`."""

    joint: int | None
    depends_on: list[str]
    term: str
    words: str = ""


class ErrorsRecord(Record, frozen=True, kw_only=True):
    """Root mean square errors by role and joint [N m], with intervals at 95 %."""

    before: ByRole
    after: ByRole
    noise_floor: ByRole
    before_interval: dict[str, Matrix]
    after_interval: dict[str, Matrix]
    change_interval: dict[str, Matrix]
    rows_counted: ByRole


class RelativeErrorsRecord(Record, frozen=True, kw_only=True):
    """The same over the torque's root mean square."""

    before: ByRole
    after: ByRole
    noise_floor: ByRole


class BudgetRecord(Record, frozen=True, kw_only=True):
    """Root mean square of what each term gives, of what is left and of noise, by joint.

    Terms are those of the model's base, by name, and what was added, by label; `words` of the latter.
    """

    recordings: str
    rms: dict[str, Numbers]
    left: Numbers
    noise_floor: Numbers
    words: dict[str, str] = msgspec.field(default_factory=dict)


class DiagnosisRecord(ResultRecord, frozen=True, kw_only=True):
    """diagnosis.json."""

    data: str
    joints: list[str]
    data_notes: list[str]
    verdict: Literal["nothing found", "explained", "ambiguous", "unexplained"]
    effects: list[FoundEffectRecord]
    unexplained: list[UnexplainedRecord]
    contradicted: list[str]
    rms: ErrorsRecord
    relative_rms: RelativeErrorsRecord
    budget: BudgetRecord
    noise_source: str
    band_hz: Number
    next_experiment: str | None
    seed: int | None


class NextExperimentRecord(FileRecord, frozen=True, kw_only=True):
    """next_experiment/design.json: what the motion that tells alternatives apart promises."""

    format: int
    pairs: list[str]
    separation: Number
    separation_now: Number
    predicted_error_rate: Number
    predicted_error_rate_now: Number
    motions_compared: int
    notes: list[str]
