"""What a model.json says, as types: the JSON Schema is made from these, and every file is held to it."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta, field

from oed.errors import OedError
from oed.report.records.models import OriginRecord
from oed.report.records.record import Record

FORMAT = "oed model"
VERSION = 1
# Of what a number is: read off data, zero because it is counted in others, or taken as it was given.
Source = Literal["estimated", "regrouped", "given"]
Number = float | None  # None is no limit
Pair = Annotated[list[Number], Meta(min_length=2, max_length=2)]
Vector = Annotated[list[float], Meta(min_length=3, max_length=3)]
Rotation = Annotated[list[Vector], Meta(min_length=3, max_length=3)]


class ModelFileError(OedError):
    """A model.json that cannot be used."""


class JointRecord(Record, frozen=True, kw_only=True):
    """As `oed.robot.robot.Joint`; poses in m and as rotation matrices."""

    name: str
    kind: Literal["revolute", "prismatic"]
    parent: int
    axis: Vector
    R_PJ: Rotation
    p_PJ: Vector
    link: str
    R_LJ: Rotation
    p_LJ: Vector
    effort: Literal["N m", "A"] = "N m"


class LimitsRecord(Record, frozen=True, kw_only=True):
    """Lower and upper bound of each joint in SI units; null is none."""

    position: list[Pair]
    velocity: list[Pair]
    acceleration: list[Pair]
    torque: list[Pair]
    jerk: list[Pair]


class DescriptionRecord(Record, frozen=True, kw_only=True):
    """The robot's file as it was read, so that an export can keep its shapes.

    `folder` is that of the robot's file, seen from that of the model's: meshes are named from
    there. `sha256` is of `text`.
    """

    format: Literal["urdf", "sdf", "mjcf"]
    text: str
    sha256: str
    file: str
    folder: str


class RobotRecord(Record, frozen=True, kw_only=True):
    """Kinematics, and the inertials of the robot's file: ten a joint."""

    name: str
    source: str
    joints: Annotated[list[JointRecord], Meta(min_length=1)]
    inertials: list[float]
    limits: LimitsRecord
    held: dict[str, float] = field(default_factory=dict)
    description: DescriptionRecord | None = None


class ParameterRecord(Record, frozen=True, kw_only=True):
    """A linear parameter: `std` is null where nothing is known of it."""

    name: str
    unit: str
    joint: int | None
    value: float
    std: Number
    source: Source


class ShapeRecord(Record, frozen=True, kw_only=True):
    """A nonlinear parameter, which the effect's form holds under names of its own."""

    name: str
    unit: str
    value: float
    std: Number
    note: str | None = None


class EffectRecord(Record, frozen=True, kw_only=True):
    """A term of the torque: `form` says it whole, and `parameters` are its factors."""

    name: str
    form: dict[str, Any]
    parameters: list[ParameterRecord]
    shapes: list[ShapeRecord] = field(default_factory=list)


class MeasurementRecord(Record, frozen=True, kw_only=True):
    """What measurement does to the torque, innermost first."""

    name: str
    form: dict[str, Any]
    shapes: list[ShapeRecord] = field(default_factory=list)


class ReferenceRecord(Record, frozen=True, kw_only=True):
    """A torque as modelled, on which effects are evaluated that grow with it."""

    robot: dict[str, list[float]]
    others: list[dict[str, Any]]
    coefficients: list[float]


class CovarianceRecord(Record, frozen=True, kw_only=True):
    """Of the parameters at `columns`, counted through all effects in order."""

    columns: list[int]
    matrix: list[list[float]]


class RangesRecord(Record, frozen=True, kw_only=True):
    """Least and largest value of each joint that the estimate has seen, in SI units."""

    q: list[Pair]
    dq: list[Pair]
    ddq: list[Pair]
    tau: list[Pair]


class ModelRecord(Record, frozen=True, kw_only=True):
    """The whole file."""

    format: Literal["oed model"] = FORMAT
    version: Literal[1] = VERSION
    robot: RobotRecord
    gravity: Vector
    effects: list[EffectRecord]
    measurement: list[MeasurementRecord]
    references: list[ReferenceRecord]
    covariance: CovarianceRecord | None
    is_feasible: bool
    validity: RangesRecord | None
    origin: OriginRecord


def model_schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of model.json."""
    return msgspec.json.schema(ModelRecord)
