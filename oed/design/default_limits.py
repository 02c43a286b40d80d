"""Limits for joints whose robot file states none, each said in a note."""

from __future__ import annotations

import dataclasses

import numpy as np

from oed.robot import JointLimits, Robot

POSITION = np.pi  # [rad] half range; the largest that never winds a cable twice
PRISMATIC_POSITION = 0.5  # [m]
VELOCITY = 2.0  # [rad/s or m/s]
# From rest to the velocity limit in a fifth of a second, within what arms of this kind can do.
SECONDS_TO_SPEED = 0.2
ACCELERATION_CAP = 15.0  # [rad/s^2]


def with_default_limits(robot: Robot) -> tuple[Robot, tuple[str, ...]]:
    """Fill in the position, velocity and acceleration limits that are missing.

    A position range wider than two turns counts as unlimited: it says that the joint may turn
    for ever, not that the design should use it.

    Returns:
        The robot with finite limits, and a note on each that was assumed.
    """
    given, notes = robot.limits, []
    is_revolute = np.array([joint.kind == "revolute" for joint in robot.joints])
    half = np.where(is_revolute, POSITION, PRISMATIC_POSITION)
    width = np.diff(given.position, axis=1)[:, 0]
    is_endless = ~np.isfinite(given.position).all(axis=1) | (width > 4 * np.pi + 1e-3)
    position = np.where(is_endless[:, None], np.stack([-half, half], axis=1), given.position)
    notes += _notes(robot, is_endless, "position", half)

    no_speed = ~np.isfinite(given.velocity).all(axis=1)
    speed = np.where(no_speed, VELOCITY, np.abs(given.velocity).min(axis=1))
    velocity = np.where(no_speed[:, None], np.stack([-speed, speed], axis=1), given.velocity)
    notes += _notes(robot, no_speed, "velocity", speed)

    no_acceleration = ~np.isfinite(given.acceleration).all(axis=1)
    rate = np.minimum(speed / SECONDS_TO_SPEED, ACCELERATION_CAP)
    acceleration = np.where(
        no_acceleration[:, None], np.stack([-rate, rate], axis=1), given.acceleration
    )
    notes += _notes(robot, no_acceleration, "acceleration", rate)
    limits: JointLimits = dataclasses.replace(
        given, position=position, velocity=velocity, acceleration=acceleration
    )
    return robot.with_limits(limits), tuple(notes)


def _notes(robot: Robot, assumed: np.ndarray, kind: str, bound: np.ndarray) -> list[str]:
    return [
        f"{kind} of {robot.joint_names[j]}: not limited by the robot's file, assumed within "
        f"+-{bound[j]:.4g}"
        for j in np.flatnonzero(assumed)
    ]
