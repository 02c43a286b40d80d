"""How an arm gets from rest into a trajectory that starts moving, and out of it again."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion


def lead_in(reference: Motion, duration: float, period: float) -> Motion:
    """A motion from rest that meets the reference's first position, velocity and acceleration.

    The quintic starts at rest half the way back that the initial velocity would have come,
    which keeps it free of overshoot, and ends one period before the reference begins.

    Args:
        reference: What follows.
        duration: [s].
        period: Sampling period [s].
    """
    samples = max(1, round(duration / period))
    T = samples * period
    q, dq, ddq = reference.q[0], reference.dq[0], reference.ddq[0]
    rest = q - dq * T / 2
    coefficients = _quintic(q - rest, dq, ddq, T)
    s = np.arange(samples) * period
    powers = np.arange(6)
    values = [
        (np.where(powers >= d, _falling(powers, d), 0.0) * s[:, None] ** np.maximum(powers - d, 0))
        @ coefficients
        for d in range(3)
    ]
    return Motion(reference.t[0] - T + s, values[0] + rest, values[1], values[2])


def lead_out(reference: Motion, duration: float, period: float) -> Motion:
    """How the arm comes to rest after a trajectory: a lead-in of the reversed motion, reversed."""
    reversed_end = Motion(
        -reference.t[::-1], reference.q[::-1], -reference.dq[::-1], reference.ddq[::-1]
    )
    way = lead_in(reversed_end, duration, period)
    return Motion(-way.t[::-1], way.q[::-1], -way.dq[::-1], way.ddq[::-1])


def _quintic(
    rise: Float[ndarray, " joints"],
    dq: Float[ndarray, " joints"],
    ddq: Float[ndarray, " joints"],
    T: float,
) -> Float[ndarray, "6 joints"]:
    """Coefficients of s^0..s^5 from rest at 0 to (rise, dq, ddq) at T."""
    end = np.array(
        [[T**3, T**4, T**5], [3 * T**2, 4 * T**3, 5 * T**4], [6 * T, 12 * T**2, 20 * T**3]]
    )
    upper = np.linalg.solve(end, np.stack([rise, dq, ddq]))
    return np.concatenate([np.zeros_like(upper), upper])


def _falling(powers: ndarray, d: int) -> ndarray:
    result = np.ones(len(powers))
    for i in range(d):
        result = result * (powers - i)
    return result
