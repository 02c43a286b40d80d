"""What `oed design` writes."""

from __future__ import annotations

from typing import Any, Literal

from msgspec import field

from oed.report.records.record import FileRecord, Matrix, Number, Numbers, Record


class WorthRecord(Record, frozen=True, kw_only=True):
    """cond Lambda and log10 det Lambda."""

    J_k: Number
    J_d_log10: Number


class DEfficiencyRecord(Record, frozen=True, kw_only=True):
    """As `oed.design.bound.efficiency.DEfficiency`."""

    value: Number
    kind: str
    J_d_bound: Number
    how: str


class LargestRecord(Record, frozen=True, kw_only=True):
    """Proven largest magnitude of each joint; torque is null where it has no limit."""

    position: Numbers
    velocity: Numbers
    acceleration: Numbers
    torque: Numbers | None
    jerk: Numbers | None = None


class SumRecord(Record, frozen=True, kw_only=True):
    """Bounds on a sum of positions."""

    factors: Numbers
    position: Numbers


class LimitsRecord(Record, frozen=True, kw_only=True):
    """Lower and upper bound of each joint; null is none."""

    position: Matrix
    velocity: Matrix
    acceleration: Matrix
    torque: Matrix
    sums: list[SumRecord]
    jerk: Matrix | None = None


class AskedRecord(Record, frozen=True, kw_only=True):
    """A limit with its standing, as `oed.design.status.LimitStatus`."""

    limit: str
    standing: str
    evidence: str
    is_demanded: bool


class NearestRecord(Record, frozen=True, kw_only=True):
    """The least distance of one kind of pair [m], and what is proven to be to spare."""

    least: Number
    pair: list[str] | None
    time: Number
    spare: Number


class ClearanceRecord(Record, frozen=True, kw_only=True):
    """As `oed.design.clearance.ClearanceCheck`."""

    wanted: Number
    bodies: NearestRecord | None
    walls: NearestRecord | None
    instants: int
    note: str
    missing: list[str]
    unjudged: list[str]
    nearer: str
    short: Numbers


class RobustWorthRecord(Record, frozen=True, kw_only=True):
    """A motion under drawn models; the criterion as it is optimised, what is known before counted.

    `largest_share` of a torque limit under any of them, null where torque is not limited; `exceeding`
    is how many of them exceed one.
    """

    nominal: Number
    expected: Number
    worst: Number
    largest_share: Number
    exceeding: int


class RobustRecord(Record, frozen=True, kw_only=True):
    """With `--robust`: the motion for the nominal model alone and the robust one, under the same draws."""

    aim: Literal["expected", "worst"]
    criterion: str
    scenarios: int
    has_shapes: bool
    nominal_design: RobustWorthRecord
    robust_design: RobustWorthRecord


class DesignRecord(FileRecord, frozen=True, kw_only=True):
    """design.json; limits and margins as they were designed for, `robot_limits` without margin."""

    format: int
    robot: str
    joints: list[str]
    family: str = field(name="class")
    coefficients: dict[str, Any]
    horizon: float
    instants: int
    rows: int
    base_parameters: list[str]
    criterion: str
    J_k: Number
    J_k_continuous: Number
    J_k_scaled: Number
    J_d_log10: Number
    J_d_log10_continuous: Number
    with_prior: WorthRecord | None
    d_efficiency: DEfficiencyRecord | None
    certified_max: LargestRecord
    certified_range: dict[str, Matrix]
    certified_violation: Number
    limits: LimitsRecord
    optimiser: str
    seed: int | None
    cpu_s: float
    evaluations: int
    status: str
    usable: bool
    asked: list[AskedRecord]
    notes: list[str]
    versions: dict[str, str]
    evaluations_asked: int
    margin: float
    scale: float
    before_clearance: WorthRecord | None
    robot_limits: LimitsRecord
    gravity: list[float]
    model: str
    prior: list[str]
    clearance: ClearanceRecord
    robust: RobustRecord | None = None


class StampRecord(Record, frozen=True, kw_only=True):
    """Whole seconds and nanoseconds."""

    sec: int
    nanosec: int


class HeaderRecord(Record, frozen=True, kw_only=True):
    """std_msgs/msg/Header."""

    stamp: StampRecord
    frame_id: str


class PointRecord(Record, frozen=True, kw_only=True):
    """trajectory_msgs/msg/JointTrajectoryPoint."""

    positions: list[float]
    velocities: list[float]
    accelerations: list[float]
    effort: list[float]
    time_from_start: StampRecord


class JointTrajectoryRecord(Record, frozen=True, kw_only=True):
    """joint_trajectory.json: trajectory_msgs/msg/JointTrajectory."""

    header: HeaderRecord
    joint_names: list[str]
    points: list[PointRecord]
