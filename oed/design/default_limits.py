"""Limits for joints whose robot file states none, each said in a note."""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.robot import JointLimits, Robot

POSITION = np.pi  # [rad] half range; the largest that never winds a cable twice
PRISMATIC_POSITION = 0.5  # [m] either way: a stroke of a metre; told as assumed wherever it is used
VELOCITY = 2.0  # [rad/s or m/s]: arms of 3 to 10 kg payload allow 2 to 3; told as assumed likewise
# From rest to the velocity limit in a fifth of a second, within what arms of this kind can do.
SECONDS_TO_SPEED = 0.2
ACCELERATION_CAP = 15.0  # [rad/s^2]: a Panda allows 7.5 to 20; told as assumed likewise

UNITS = {"position": "rad", "velocity": "rad/s", "acceleration": "rad/s^2"}


def with_default_limits(robot: Robot) -> tuple[Robot, tuple[str, ...]]:
    """Fill in the position, velocity and acceleration limits that are missing.

    A position range wider than two turns counts as unlimited: it says that the joint may turn
    for ever, not that the design should use it. What is assumed stays within what is given: a
    position within a range as near to zero as that allows, a missing side of velocity or
    acceleration no larger than the other.

    Returns:
        The robot with finite limits, and a note on each that was assumed.
    """
    given, notes = robot.limits, []
    is_revolute = np.array([joint.kind == "revolute" for joint in robot.joints])
    half = np.where(is_revolute, POSITION, PRISMATIC_POSITION)
    lower, upper = given.position.T
    is_endless = ~(upper - lower <= 4 * np.pi + 1e-3)
    centre = np.minimum(np.maximum(0.0, lower + half), upper - half)
    assumed = np.stack([centre - half, centre + half], axis=1)
    position = np.where(is_endless[:, None], assumed, given.position)
    is_given = np.isfinite(given.position).all(axis=1)
    wide = "its limits are more than two turns apart"
    notes += _notes(robot, is_endless & is_given, "position", position, why=wide)
    notes += _notes(robot, is_endless & ~is_given, "position", position)

    velocity, no_speed = _both_ways(given.velocity, np.full(robot.n, VELOCITY))
    notes += _notes(robot, no_speed, "velocity", velocity)

    rate = np.minimum(np.abs(velocity).min(axis=1) / SECONDS_TO_SPEED, ACCELERATION_CAP)
    acceleration, no_rate = _both_ways(given.acceleration, rate)
    notes += _notes(robot, no_rate, "acceleration", acceleration)
    limits: JointLimits = dataclasses.replace(
        given, position=position, velocity=velocity, acceleration=acceleration
    )
    return robot.with_limits(limits), tuple(notes)


def _both_ways(
    given: Float[ndarray, "joints 2"], usual: Float[ndarray, " joints"]
) -> tuple[Float[ndarray, "joints 2"], Bool[ndarray, " joints"]]:
    """The bounds with those that are missing filled in, and where one was missing."""
    size = np.minimum(usual, np.abs(given).min(axis=1))
    filled = np.where(np.isfinite(given), given, np.stack([-size, size], axis=1))
    return filled, np.any(~np.isfinite(given), axis=1)


def _notes(
    robot: Robot,
    assumed: Bool[ndarray, " joints"],
    kind: str,
    bounds: Float[ndarray, "joints 2"],
    why: str = "no limit is given",
) -> list[str]:
    return [
        f"{kind} of {robot.joint_names[j]}: {why}, assumed within "
        f"{bounds[j, 0]:.4g} ... {bounds[j, 1]:.4g} {robot.joints[j].unit(UNITS[kind])}"
        for j in np.flatnonzero(assumed)
    ]
