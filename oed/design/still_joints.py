"""Joints whose range is too small to tell anything: held still, and said."""

from __future__ import annotations

import dataclasses

import numpy as np

from oed.errors import RobotError
from oed.robot import JointSum, Robot, load_robot
from oed.robot.limits import LIMITED

# Ten times the play of a gear, which is about a milliradian: within less, torque is that of
# friction at its reversal, which no model of this project describes.
SMALLEST_RANGE = 0.01  # [rad]; of a slide, what a pinion's rim moves meanwhile
NO_RANGE = 1e-6  # [rad] likewise: less than an encoder of 22 bits tells apart


def hold_still_joints(robot: Robot) -> tuple[Robot, tuple[str, ...]]:
    """The robot with every joint of too small a range held at the middle of it.

    Returns:
        The robot, and a note on each joint that is held.

    Raises:
        RobotError: If no joint is left, if the robot has no file to read again, or if limits are
            so close, and not equal, that they can be neither a range nor meant to hold the joint.
    """
    lower, upper = robot.limits.position.T
    _check_ranges(robot)
    smallest = np.array([joint.speed(SMALLEST_RANGE) for joint in robot.joints])
    is_still = upper - lower < smallest
    if not is_still.any():
        return robot, ()
    names = np.array(robot.joint_names)
    if is_still.all():
        raise RobotError(
            f"{robot.source}: no joint has a position range that matters: all are below "
            f"{SMALLEST_RANGE:g} rad"
        )
    if robot.source.startswith("builtin:"):
        raise RobotError(f"{robot.source}: position limits of {names[is_still][0]} leave no motion")
    at = dict(zip(names[is_still], (lower + upper)[is_still] / 2, strict=True))
    held = load_robot(
        robot.source,
        joints=[str(name) for name in names[~is_still]],
        locked={**robot.held, **{str(name): float(q) for name, q in at.items()}},
        gravity=robot.gravity.tolist(),
    )
    notes = tuple(
        f"{joint.name} is held at {at[joint.name]:.4g}: its range of {high - low:.2g} "
        f"{'rad' if joint.kind == 'revolute' else 'm'} is too small to tell anything"
        for joint, low, high, still in zip(robot.joints, lower, upper, is_still, strict=True)
        if still
    )
    # What was said when the file was first read stays true, such as which arm was taken.
    told = tuple(dict.fromkeys((*robot.notes, *held.notes)))
    # A data set's limits, where it states any, go before those of the file.
    rest = {kind: getattr(robot.limits, kind)[~is_still] for kind in LIMITED}
    limits = held.limits.with_(**rest).with_sums(_remaining_sums(robot, held))
    return dataclasses.replace(held, limits=limits, notes=told), notes


def _remaining_sums(robot: Robot, held: Robot) -> list[JointSum]:
    """Bounds on sums of positions, for the joints that are left."""
    sums = []
    for each in robot.limits.sums:
        factors = dict(zip(robot.joint_names, each.factors, strict=True))
        left = JointSum.of(factors, (each.lower, each.upper), held.joint_names, held.held)
        sums += [] if left is None else [left]
    return sums


def _check_ranges(robot: Robot) -> None:
    for joint, (lower, upper) in zip(robot.joints, robot.limits.position, strict=True):
        is_equal = upper - lower <= 2 * np.spacing(max(abs(lower), abs(upper)))
        if upper - lower < joint.speed(NO_RANGE) and not is_equal:
            raise RobotError(
                f"{robot.source}: position limits of {joint.name}, {lower:g} ... {upper:g}, are "
                "closer than an encoder tells apart: correct them, make the joint `fixed` in the "
                "file, or name the joints that are to move (--joints)"
            )
