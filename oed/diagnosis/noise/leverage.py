"""What a fit takes of noise, frequency by frequency: of slow noise more than of fast.

The columns of a model change as slowly as its motion.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.ndimage import uniform_filter1d

NEIGHBOURS = 9  # frequencies over which it is averaged: noise has a smooth colour


def taken_of_noise(
    basis: Float[ndarray, "*joints rows rank"],
) -> Float[ndarray, "*joints frequencies"]:
    """Share of the noise of one stretch of rows that a fit takes, at each frequency of `rfft`.

    Args:
        basis: Orthonormal columns of the fit, over all its stretches; these rows of them.
    """
    spectra = np.fft.rfft(basis, axis=-2)
    return np.sum(spectra.real**2 + spectra.imag**2, axis=-1) / basis.shape[-2]


def left_of_noise(
    taken: Float[ndarray, "*joints frequencies"], seen: Bool[ndarray, "*joints rows"]
) -> Float[ndarray, "*joints frequencies"]:
    """Share of the noise of the fitted rows that a fit leaves.

    Args:
        taken: What it takes.
        seen: Rows that were fitted.
    """
    there = np.maximum(seen.mean(axis=-1, keepdims=True), 1 / seen.shape[-1])
    return 1 - uniform_filter1d(taken, NEIGHBOURS, axis=-1) / there
