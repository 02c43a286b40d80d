"""Starts that know what good motions look like."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.problem import DesignProblem

STRUCTURED_SHARE = (
    0.3  # of the starts; the others are random, so that nothing rests on the structure; assumed
)


def structured_start(problem: DesignProblem, rng: np.random.Generator) -> Float[ndarray, " size"]:
    """Each joint swings as far and fast as its limits allow, joints at different rates.

    A class that knows no such motion gets a random start.
    """
    trajectory = problem.trajectory
    room, rate = _swing(problem)
    rate = rate * rng.uniform(0.7, 1.0, trajectory.joints)
    jitter = 1e-3 * np.diff(trajectory.bounds, axis=1)[:, 0] * rng.standard_normal(problem.size)
    z = trajectory.swing(problem.limits.position.mean(axis=1), room, rate)
    return problem.random_start(rng) if z is None else problem.repair(z + jitter)


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
