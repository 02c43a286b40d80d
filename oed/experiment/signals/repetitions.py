"""A signal cut into the repetitions of one motion."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray


def fold_by_index(
    x: Float[ndarray, "samples columns"], repetition: Int[ndarray, " samples"]
) -> Float[ndarray, "repetitions phases columns"]:
    """Cut a signal into the repetitions that `repetition` (N,) numbers, sample by sample.

    Raises:
        ValueError: If the repetitions differ in their number of samples.
    """
    indices, counts = np.unique(repetition, return_counts=True)
    if len(set(counts.tolist())) != 1:
        raise ValueError(
            f"repetitions hold {counts.min()} to {counts.max()} samples; fold by period instead"
        )
    return np.stack([x[repetition == index] for index in indices])
