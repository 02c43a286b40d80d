"""Positions across gaps of a log."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.interpolate import BPoly

from oed.experiment.signals.gaps import find_gaps
from oed.experiment.signals.resampling import resample

NEAR = 0.1  # [s] before and after a gap from which the state at its edge is taken


def bridged(
    t: Float[ndarray, " logged"],
    q: Float[ndarray, "logged joints"],
    grid: Float[ndarray, " samples"],
    rate: float,
) -> Float[ndarray, "samples joints"]:
    """Positions on a grid, across gaps as smoothly as an arm that goes on would move.

    Nothing is compared within a gap, but what remembers, such as a spring, would ring for long
    from any jump of the acceleration.
    """
    result = resample(t, q, grid)
    for k in find_gaps(t, rate):
        before, after = (t > t[k] - NEAR) & (t <= t[k]), (t >= t[k + 1]) & (t < t[k + 1] + NEAR)
        states = [
            _state(t[near] - t[edge], q[near]) for near, edge in ((before, k), (after, k + 1))
        ]
        bridge = BPoly.from_derivatives(t[[k, k + 1]], states)
        inside = (grid > t[k]) & (grid < t[k + 1])
        result[inside] = bridge(grid[inside])
    return result


def _state(
    t: Float[ndarray, " logged"], q: Float[ndarray, "logged joints"]
) -> Float[ndarray, "3 joints"]:
    """Position, velocity and acceleration at t = 0 of a parabola through the samples."""
    state = np.zeros((3, q.shape[1]))
    powers = np.vander(t, min(3, len(t)), increasing=True)
    fitted = np.linalg.lstsq(powers, q, rcond=None)[0]
    state[: len(fitted)] = fitted
    state[2] *= 2
    return state
