"""Limits on a motion: how far a motion is from them, proof that it keeps them, repair."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.extrema import proven_range, quick_range
from oed.design.joint_sums import JointSums, roomiest_posture
from oed.design.trajectories import TrajectoryClass
from oed.robot import JointLimits

KINEMATIC = ("position", "velocity", "acceleration", "jerk")  # index = order of derivative
# A repaired motion stays this fraction inside, so that no rounding can carry it out again.
MARGIN = 1e-9


@dataclass(frozen=True)
class Certificate:
    """Bounds that a motion never leaves at any t in its horizon.

    Attributes:
        position: (n, 2) lower and upper bound [rad or m].
        velocity: (n, 2) [rad/s].
        acceleration: (n, 2) [rad/s^2].
        jerk: (n, 2) [rad/s^3].
        torque: (n, 2) of the nominal model [N m]; None where no model was given.
        violation: Worst violation of any limit, relative to it; <= 0 proves feasibility.
        worst: Which limit that is, in words.
        sums: (c, 2) of the sums of positions that are bounded [rad or m].
    """

    position: Float[ndarray, "joints 2"]
    velocity: Float[ndarray, "joints 2"]
    acceleration: Float[ndarray, "joints 2"]
    jerk: Float[ndarray, "joints 2"]
    torque: Float[ndarray, "joints 2"] | None
    violation: float
    worst: str
    sums: Float[ndarray, "sums 2"]

    @property
    def is_feasible(self) -> bool:
        """Whether every limit is proven to be kept."""
        return self.violation <= 0.0

    @property
    def nearest(self) -> str:
        """The limit that is nearest, and how near, in words."""
        share = abs(self.violation)
        if self.is_feasible:
            return f"{self.worst}, proven {share:.2e} of it to spare"
        return f"{self.worst}, exceeded by {share:.2e} of it"

    @property
    def certified_max(self) -> dict[str, list[float]]:
        """Largest magnitude of each kind and joint, for a design file."""
        kinds = {kind: getattr(self, kind) for kind in (*KINEMATIC, "torque")}
        return {
            kind: np.abs(bounds).max(axis=1).tolist()
            for kind, bounds in kinds.items()
            if bounds is not None
        }


def check_limits(limits: JointLimits) -> None:
    """Refuse limits that forbid standing still.

    Raises:
        ValueError: If a velocity, acceleration, jerk or torque range excludes zero, or if no
            posture is within the limits of positions and of their sums.
    """
    for kind in ("velocity", "acceleration", "jerk"):
        lower, upper = getattr(limits, kind).T
        wrong = ~((lower < 0) & (upper > 0))
        if wrong.any():
            joint = int(np.flatnonzero(wrong)[0])
            raise ValueError(
                f"{kind} limit of joint {joint + 1}, [{lower[joint]:g}, {upper[joint]:g}], "
                "does not allow motion in both directions"
            )
    if limits.sums:
        roomiest_posture(limits)


def certify(
    trajectory: TrajectoryClass,
    z: Float[ndarray, " size"],
    limits: JointLimits,
    torque: Float[ndarray, "joints 2"] | None = None,
) -> Certificate:
    """Prove bounds on a motion and compare them with the limits.

    Args:
        trajectory: The class.
        z: The motion.
        limits: Of the joints.
        torque: (n, 2) proven bounds on the nominal torque, where there is a nominal model.
    """
    ranges = {kind: proven_range(trajectory, z, order) for order, kind in enumerate(KINEMATIC)}
    checked = ranges if torque is None else {**ranges, "torque": torque}
    worst = {kind: violation_of(bounds, getattr(limits, kind)) for kind, bounds in checked.items()}
    sums = np.zeros((0, 2))
    if limits.sums:
        sums = proven_range(JointSums(trajectory, limits.sum_factors), z, 0)
        worst["sum"] = violation_of(sums, limits.sum_bounds)
    kind = max(worst, key=lambda k: worst[k].max())
    joint = int(worst[kind].argmax())
    return Certificate(
        **ranges,
        torque=torque,
        violation=float(worst[kind][joint]),
        worst=f"sum {joint + 1}" if kind == "sum" else f"{kind} of joint {joint + 1}",
        sums=sums,
    )


def violation_of(
    bounds: Float[ndarray, "joints 2"], limit: Float[ndarray, "joints 2"]
) -> Float[ndarray, " joints"]:
    """Violation of each joint relative to half the width of its range; -1 where unlimited.

    Where only one side is limited, relative to that side's magnitude.
    """
    half = np.diff(limit, axis=1)[:, 0] / 2
    finite = np.where(np.isfinite(limit), np.abs(limit), 0.0).max(axis=1)
    scale = np.where(np.isfinite(half), half, np.where(finite > 0, finite, 1.0))
    beyond = np.maximum(limit[:, 0] - bounds[:, 0], bounds[:, 1] - limit[:, 1])
    return np.maximum(beyond / scale, -1.0)


def sampled_ranges(
    trajectory: TrajectoryClass, z: Float[ndarray, " size"], t: Float[ndarray, " samples"]
) -> dict[str, Float[ndarray, "joints 2"]]:
    """Smallest and largest sample of each kinematic quantity: fast, and no proof."""
    ranges = {}
    for order, kind in enumerate(KINEMATIC):
        values = trajectory.derivative(z, t, order)
        ranges[kind] = np.stack([values.min(axis=0), values.max(axis=0)], axis=1)
    return ranges


def repair(
    trajectory: TrajectoryClass,
    z: Float[ndarray, " size"],
    limits: JointLimits,
    *,
    is_quick: bool = False,
) -> Float[ndarray, " size"]:
    """Scale each joint's motion about its centre, and move that centre, into the limits.

    Where a sum of positions is bounded, all joints then shrink by one factor, towards the posture
    with most room. The result provably keeps limits of position, velocity, acceleration, jerk and
    sums. A motion that is proven to keep them already is returned as it is.

    Args:
        trajectory: The class.
        z: The motion.
        limits: To be kept.
        is_quick: Whether to use the wider bounds of `quick_range`: the motion then stays a
            fraction of a percent inside its limits, at a tenth of the time.
    """
    z = _within_own(trajectory, z, limits, is_quick=is_quick)
    return _within_sums(trajectory, z, limits, is_quick=is_quick) if limits.sums else z


def _within_sums(
    trajectory: TrajectoryClass, z: Float[ndarray, " size"], limits: JointLimits, *, is_quick: bool
) -> Float[ndarray, " size"]:
    """Every limit forms a convex set that holds the posture at rest: the way to it keeps them."""
    sums, bounds = JointSums(trajectory, limits.sum_factors), limits.sum_bounds
    ranges = (quick_range if is_quick else proven_range)(sums, z, 0)
    if (violation_of(ranges, bounds) <= 0).all():
        return z
    centre = trajectory.centre(z)
    posture = roomiest_posture(limits) if trajectory.has_offset else centre
    at = (limits.sum_factors @ posture)[:, None]
    factor = float(np.clip(_two_sided(bounds - at, ranges - at).min(), 0.0, 1.0)) * (1 - MARGIN)
    smaller = trajectory.shrink(z, np.full(trajectory.joints, factor))
    return trajectory.shift(smaller, (1 - factor) * (posture - centre))


def _within_own(
    trajectory: TrajectoryClass, z: Float[ndarray, " size"], limits: JointLimits, *, is_quick: bool
) -> Float[ndarray, " size"]:
    """The motion with each joint within the limits of its own."""
    z = trajectory.clip(z)
    if trajectory.box_keeps_limits and not np.isfinite(limits.jerk).any():
        return z
    bound = quick_range if is_quick else proven_range
    ranges = {k: bound(trajectory, z, KINEMATIC.index(k)) for k in _limited(limits)}
    if all((violation_of(b, getattr(limits, k)) <= 0).all() for k, b in ranges.items()):
        return z
    factors = np.minimum(_kinematic_factors(trajectory, z, limits, ranges), 1.0)
    z = trajectory.shrink(z, factors)
    if trajectory.has_offset:
        centre = trajectory.centre(trajectory.clip(z))
        swing = (ranges["position"] - centre[:, None]) * factors[:, None] + centre[:, None]
        slack = MARGIN * np.maximum(1.0, np.abs(swing))
        up = np.maximum(limits.position[:, 0] - (swing - slack)[:, 0], 0.0)
        down = np.minimum(limits.position[:, 1] - (swing + slack)[:, 1], 0.0)
        z = trajectory.shift(z, up + down)
    return z


def fill(
    trajectory: TrajectoryClass, z: Float[ndarray, " size"], limits: JointLimits
) -> Float[ndarray, " size"]:
    """Scale each joint up or down until it touches one of its limits, then repair.

    Joints that do not move, or whose limits leave them free, stay as they are.
    """
    ranges = {k: quick_range(trajectory, z, KINEMATIC.index(k)) for k in _limited(limits)}
    factors = _kinematic_factors(trajectory, z, limits, ranges)
    grown = trajectory.shrink(z, np.where(np.isfinite(factors), factors, 1.0))
    return repair(trajectory, grown, limits, is_quick=True)


def _limited(limits: JointLimits) -> list[str]:
    """Kinds of which a joint has a limit, and position, about which it is scaled."""
    return [k for k in KINEMATIC if k == "position" or np.isfinite(getattr(limits, k)).any()]


def _kinematic_factors(
    trajectory: TrajectoryClass,
    z: Float[ndarray, " size"],
    limits: JointLimits,
    ranges: dict[str, Float[ndarray, "joints 2"]],
) -> Float[ndarray, " joints"]:
    """The largest factor of each joint that keeps all its ranges within limits."""
    centre = trajectory.centre(z)
    if trajectory.has_offset:
        room = np.diff(limits.position, axis=1)[:, 0]
        # Room for the slack of the shift on both sides.
        room = room - 4 * MARGIN * np.maximum(1.0, np.abs(limits.position).max(axis=1))
        factors = _ratio(room, np.diff(ranges["position"], axis=1)[:, 0])
    else:
        factors = _two_sided(
            limits.position - centre[:, None], ranges["position"] - centre[:, None]
        )
    for kind in ranges.keys() - {"position"}:
        factors = np.minimum(factors, _two_sided(getattr(limits, kind), ranges[kind]))
    return factors * (1 - MARGIN)


def _two_sided(limit: ndarray, extent: ndarray) -> Float[ndarray, " joints"]:
    return np.minimum(_ratio(-limit[:, 0], -extent[:, 0]), _ratio(limit[:, 1], extent[:, 1]))


def _ratio(room: ndarray, needed: ndarray) -> Float[ndarray, " joints"]:
    """How many times the need fits the room; infinite where nothing is needed."""
    is_needed = needed > 0.0
    return np.where(is_needed, room / np.where(is_needed, needed, 1.0), np.inf)
