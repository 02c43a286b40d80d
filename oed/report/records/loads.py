"""What `oed payload` and `oed gains` write."""

from __future__ import annotations

from typing import Any

from oed.report.records.estimating import ProcessingRecord
from oed.report.records.record import Matrix, Number, Numbers, Record, ResultRecord


class QuantityRecord(Record, frozen=True, kw_only=True):
    """One number of a load; its interval is at 95 %, null where the data do not bound it."""

    name: str
    unit: str
    value: Number
    interval: Numbers | None
    is_determined: bool


class LeastSquaresRecord(Record, frozen=True, kw_only=True):
    """The ten parameters of the load before any demand."""

    parameters: Numbers
    covariance: Matrix


class LoadFrictionRecord(Record, frozen=True, kw_only=True):
    """Friction that grows with the load, and the mass of a model without it."""

    joints: list[str]
    mu: Numbers
    interval95: Matrix
    mass_without: Number
    interval95_without: Numbers | None


class OpenQuantityRecord(Record, frozen=True, kw_only=True):
    """What the recordings leave open, and what would tell it."""

    name: str
    what: str
    remedy: str


class PayloadRecord(ResultRecord, frozen=True, kw_only=True):
    """payload.json."""

    data: str
    frame: str
    route: str
    arm: str
    mass: Number
    centre_of_mass: Numbers
    quantities: list[QuantityRecord]
    parameters: Numbers
    least_squares: LeastSquaresRecord
    pseudo_inertia_margin: Number
    solver: str
    load_friction: LoadFrictionRecord | None
    not_told: list[OpenQuantityRecord]
    relative_rms: Numbers
    notes: list[str]
    files: list[str]
    processing: ProcessingRecord
    configuration: dict[str, Any]
    date: str


class GainRecord(Record, frozen=True, kw_only=True):
    """One joint's gain in its unit, or null with the reason."""

    joint: str
    value: Number
    interval: Numbers | None
    reason: str
    unit: str


class GainsRecord(ResultRecord, frozen=True, kw_only=True):
    """gains.json."""

    data: str
    joints: list[str]
    frame: str
    reference: str | None
    gains: list[GainRecord]
    log_gain_covariance: Matrix
    loads: Matrix
    solver: str
    relative_rms: Numbers
    notes: list[str]
    configuration: dict[str, Any]
    date: str
