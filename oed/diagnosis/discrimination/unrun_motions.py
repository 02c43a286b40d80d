"""Motions that nobody has run yet: drawn within the limits, and laid out like recordings."""

from __future__ import annotations

import dataclasses

import numpy as np

from oed.design.default_limits import with_default_limits
from oed.design.limits import fill
from oed.design.trajectories import FourierClass
from oed.dynamics.motion import Motion
from oed.experiment.preparation.prepared import Prepared
from oed.robot import Robot

HARMONICS = (5, 10, 15)  # more harmonics separate delays and lags, few separate slow effects
AMPLITUDES = (1.0, 0.3, 0.1)  # of what the limits allow: small ones tell Dahl from Stribeck


def random_motions(
    robot: Robot, pattern: Prepared, rng: np.random.Generator, count: int
) -> tuple[list[Motion], tuple[str, ...]]:
    """Periodic motions within the limits, each as long as one run of a recording; and assumed limits.

    Args:
        robot: The arm.
        pattern: The recording.
        rng: Draws them.
        count: How many, at least one.
    """
    if count < 1:
        raise ValueError(f"{count} motions leave nothing to choose from")
    robot, notes = with_default_limits(robot)
    # The edges that preparing cuts are part of a run.
    horizon = (len(pattern.motion) + 2 * pattern.band.cut) / pattern.band.rate
    instants = np.arange(0.0, horizon, 1 / pattern.band.rate)
    motions = []
    for k in range(count):
        cycle = FourierClass(horizon, robot.limits, harmonics=HARMONICS[k % len(HARMONICS)])
        z = fill(cycle, cycle.draw(rng), robot.limits)
        amplitude = AMPLITUDES[(k // len(HARMONICS)) % len(AMPLITUDES)]
        motions.append(cycle.motion(cycle.shrink(z, np.full(robot.n, amplitude)), instants))
    return motions, notes


def as_prepared(pattern: Prepared, motion: Motion) -> Prepared:
    """A motion that nobody has run yet, prepared as a recording was; its torque is zero."""
    silent = np.zeros_like(motion.q)
    torque = pattern.band.apply(silent)
    return dataclasses.replace(
        pattern,
        name="next",
        role="estimation",
        motion=motion,
        fine_torque=silent,
        torque=torque,
        t=pattern.band.instants(motion.t),
        repetition=np.full(len(torque), -1),
        period=None,
        recorded=np.ones(len(motion), dtype=bool),
        laid=False,
        laps=None,
    )
