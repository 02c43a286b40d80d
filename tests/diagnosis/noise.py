"""Noise of any colour for tests of what repetitions differ by."""

import numpy as np
from scipy.signal import lfilter

SETTLING = 500  # samples


def coloured(rng, samples, pole):
    """(samples, 2) of unit variance, one sample after another correlated by `pole`."""
    white = rng.normal(size=(samples + SETTLING, 2))
    return np.asarray(lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], white, axis=0))[SETTLING:]
