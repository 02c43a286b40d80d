"""Gaps in the time of a log: a logger that paused, or several runs in one file."""

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

GAP = 10.0  # sampling steps without a row that make a gap


def find_gaps(t: Float[ndarray, " samples"], rate: float) -> Int[ndarray, " gaps"]:
    """Indices of the samples before each gap.

    Args:
        t: (N,) increasing instants [s].
        rate: Of the samples that are needed [Hz]; a log that is finer may miss some.
    """
    steps = np.diff(t)
    if not len(steps):
        return np.zeros(0, dtype=int)
    return np.flatnonzero(steps > GAP * max(float(np.median(steps)), 1 / rate))
