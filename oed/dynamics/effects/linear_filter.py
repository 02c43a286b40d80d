"""Response of a linear time-invariant filter to sampled columns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.interpolate import make_interp_spline
from scipy.signal import TransferFunction, lfilter, lfilter_zi

# Spacing that varies by less than this fraction of itself is taken as uniform.
UNIFORM = 1e-3
# Steps within which a part of a filter settles that the samples cannot show.
INSTANT = 1e-3


def respond(
    t: Float[ndarray, " samples"],
    u: Float[ndarray, "samples joints columns"],
    numerator: Sequence[float],
    denominator: Sequence[float],
) -> Float[ndarray, "samples joints columns"]:
    """What a filter of unit gain at rest makes of each column.

    The input is taken as straight between samples (first-order hold), the filter as settled
    at the first sample. Unevenly spaced samples go through an even grid and back.

    Args:
        t: Time [s].
        u: The filter acts along the samples.
        numerator: Coefficients of the transfer function, highest power of s [1/s] first.
        denominator: Likewise.
    """
    step = float(np.median(np.diff(t)))
    if is_even(t):
        return _respond_evenly(u, step, numerator, denominator)
    even = np.linspace(t[0], t[-1], 1 + round((t[-1] - t[0]) / step))
    seen = make_interp_spline(t, u, k=1, axis=0)(even)
    answer = _respond_evenly(seen, float(even[1] - even[0]), numerator, denominator)
    return make_interp_spline(even, answer, k=1, axis=0)(t)


def is_even(t: Float[ndarray, " samples"]) -> bool:
    """Whether instants are as good as evenly spaced."""
    spacing = np.diff(t)
    step = float(np.median(spacing))
    return bool(np.all(np.abs(spacing - step) <= UNIFORM * step))


def _respond_evenly(
    u: Float[ndarray, "samples joints columns"],
    step: float,
    numerator: Sequence[float],
    denominator: Sequence[float],
) -> Float[ndarray, "samples joints columns"]:
    b, a = discrete(step, numerator, denominator)
    settled = lfilter_zi(b, a)[:, None, None] * u[:1]
    answer, _ = lfilter(b, a, u, axis=0, zi=settled)
    return answer


def discrete(
    step: float, numerator: Sequence[float], denominator: Sequence[float]
) -> tuple[Float[ndarray, " order"], Float[ndarray, " order"]]:
    """Coefficients of a filter whose input is straight between evenly spaced samples.

    Args:
        step: Between two samples [s].
        numerator: As of `respond`.
        denominator: Likewise.

    Returns:
        Those of the input, and of the output.
    """
    # Time in steps: coefficients of s^k in seconds^k can span ten orders of magnitude.
    scaled = [
        [c / step ** (len(poly) - 1 - k) for k, c in enumerate(poly)]
        for poly in (numerator, denominator)
    ]
    denominators = scaled[1]
    while len(denominators) > 2 and denominators[0] < INSTANT * denominators[1]:
        denominators.pop(0)
    found = TransferFunction(*scaled).to_discrete(1.0, method="foh")
    return np.asarray(found.num), np.asarray(found.den)
