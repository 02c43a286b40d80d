"""Random Fourier motions within an arm's limits."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.robot import JointLimits

HARMONICS = 7
CHECKED = 0.01  # [s] grid on which a motion is held against the limits


def random_fourier_motion(
    limits: JointLimits,
    duration: float,
    highest: float,
    sample_time: float,
    rng: np.random.Generator,
) -> Motion:
    """One period of a random motion that comes close to a limit at every joint.

    Every joint gets a few harmonics of the period, drawn up to the highest frequency, and is
    scaled to between 65 and 90 % of what the tightest of its limits allows.

    Args:
        limits: Of position, velocity and acceleration; all finite.
        duration: Of the period [s].
        highest: Frequency [Hz].
        sample_time: [s].
        rng: Source of every draw.
    """
    n = len(limits.position)
    available = np.arange(1, max(HARMONICS, int(highest * duration)) + 1)
    base = 2 * np.pi / duration
    t = np.arange(round(duration / sample_time)) * sample_time
    q, dq, ddq = (np.empty((len(t), n)) for _ in range(3))
    for j in range(n):
        orders = rng.choice(available, HARMONICS, replace=False)
        omega = base * np.sort(orders)
        # Slow harmonics swing wider, so that position and speed both come near their limits.
        coefficients = rng.standard_normal((2, HARMONICS)) / omega**1.3
        scale, centre = _fit(limits, j, omega, coefficients, rng)
        for values, order in ((q, 0), (dq, 1), (ddq, 2)):
            values[:, j] = scale * _series(omega, coefficients, t, order)
        q[:, j] += centre
    return Motion(t, q, dq, ddq)


def _fit(
    limits: JointLimits,
    joint: int,
    omega: Float[ndarray, " harmonics"],
    coefficients: Float[ndarray, "2 harmonics"],
    rng: np.random.Generator,
) -> tuple[float, float]:
    """Scale and centre with which the series keeps a joint's limits."""
    grid = np.arange(0.0, 2 * np.pi / omega.min() * len(omega), CHECKED)
    lower, upper = limits.position[joint]
    q, dq, ddq = (_series(omega, coefficients, grid, order) for order in range(3))
    largest = min(
        (upper - lower) / np.ptp(q),
        limits.velocity[joint].min(where=limits.velocity[joint] > 0, initial=np.inf)
        / np.abs(dq).max(),
        limits.acceleration[joint].min(where=limits.acceleration[joint] > 0, initial=np.inf)
        / np.abs(ddq).max(),
    )
    scale = largest * rng.uniform(0.65, 0.9)
    low, high = lower - scale * q.min(), upper - scale * q.max()
    return scale, low + (high - low) * rng.uniform(0.3, 0.7)


def _series(
    omega: Float[ndarray, " harmonics"],
    coefficients: Float[ndarray, "2 harmonics"],
    t: Float[ndarray, " samples"],
    order: int,
) -> Float[ndarray, " samples"]:
    """The derivative of that order of sum a sin(w t) + b cos(w t)."""
    phase = np.outer(t, omega) + order * np.pi / 2
    a, b = coefficients * omega**order
    return np.sin(phase) @ a + np.cos(phase) @ b
