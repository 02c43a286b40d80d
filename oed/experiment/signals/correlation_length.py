"""Rows over which a signal is correlated: so many count as one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray


def correlation_length(stretches: Sequence[Float[ndarray, " _"]]) -> float:
    """1 + 2 sum of the autocorrelation up to its first zero (Priestley 1981, section 5.3).

    Args:
        stretches: Of one signal, at one rate; its mean is taken to be zero.
    """
    covariance = np.zeros(max(len(stretch) for stretch in stretches))
    for stretch in stretches:
        spectrum = np.abs(np.fft.rfft(stretch, 2 * len(stretch))) ** 2
        covariance[: len(stretch)] += np.fft.irfft(spectrum)[: len(stretch)]
    if covariance[0] <= 0:
        return 1.0
    rho = covariance / covariance[0]
    beyond = np.flatnonzero(rho <= 0)
    end = int(beyond[0]) if len(beyond) else len(rho)
    return float(max(1.0, 2 * rho[:end].sum() - 1))
