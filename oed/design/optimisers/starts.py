"""Starts that know what good motions look like."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass, HarmonicClass

# The D-optimal motion of one joint between position and acceleration limits is close to
# A (sin wt + sin(3 wt) / 54): the third harmonic flattens the acceleration.
THIRD_HARMONIC = 1 / 54
# Largest value of sin x + THIRD_HARMONIC sin 3x, at 90 degrees, and of sin x + 9 THIRD_HARMONIC
# sin 3x, at 60 degrees: what the third harmonic leaves of position and acceleration.
POSITION_CREST = 1 - THIRD_HARMONIC
ACCELERATION_CREST = np.sqrt(3) / 2
STRUCTURED_SHARE = 0.3


def structured_start(problem: DesignProblem, rng: np.random.Generator) -> Float[ndarray, " size"]:
    """Each joint swings as far and fast as its limits allow, joints at different rates.

    Classes other than the paper's and Fourier's get a random start.
    """
    trajectory = problem.trajectory
    room, rate = _swing(problem)
    rate = rate * rng.uniform(0.7, 1.0, trajectory.joints)
    jitter = 1e-3 * np.diff(trajectory.bounds, axis=1)[:, 0] * rng.standard_normal(problem.size)
    if isinstance(trajectory, HarmonicClass):
        if trajectory.terms > 1 and not trajectory.box_keeps_limits:
            room = room / POSITION_CREST
            rate = rate * np.sqrt(POSITION_CREST / ACCELERATION_CREST)
        a = np.zeros((trajectory.joints, trajectory.terms))
        omega = np.tile(rate[:, None], (1, trajectory.terms))
        a[:, 0] = room
        if trajectory.terms > 1:
            a[:, 1] = room * THIRD_HARMONIC
            omega[:, 1] = 3 * rate
        return problem.repair(np.concatenate([a.reshape(-1), omega.reshape(-1)]) + jitter)
    if isinstance(trajectory, FourierClass) and not trajectory.at_rest:
        own = np.zeros((trajectory.joints, 1 + 2 * trajectory.harmonics))
        own[:, 0] = problem.limits.position.mean(axis=1)
        cycles = np.clip(np.round(rate / trajectory.fundamental), 1, trajectory.harmonics)
        joints = np.arange(trajectory.joints)
        own[joints, cycles.astype(int)] = room
        return problem.repair(own.reshape(-1) + jitter)
    return problem.random_start(rng)


def mixed_start(problem: DesignProblem, rng: np.random.Generator) -> Float[ndarray, " size"]:
    """A structured start or, more often, a random one."""
    is_structured = rng.random() < STRUCTURED_SHARE
    return structured_start(problem, rng) if is_structured else problem.random_start(rng)


def _swing(problem: DesignProblem) -> tuple[ndarray, ndarray]:
    """Amplitude that fills the position range, and the frequency that fills the other limits."""
    limits = problem.limits
    room = np.diff(limits.position, axis=1)[:, 0] / 2
    speed = np.abs(limits.velocity).min(axis=1)
    acceleration = np.abs(limits.acceleration).min(axis=1)
    rate = np.minimum(speed / room, np.sqrt(acceleration / room))
    highest = np.abs(problem.trajectory.bounds).max()
    return room, np.where(np.isfinite(rate), rate, highest)
