"""Weighted sums over the windows of a signal: a finite impulse response, of few rows if need be."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from numpy.lib.stride_tricks import sliding_window_view


def moving_sum(
    x: Float[ndarray, " samples *columns"], weights: Float[ndarray, " window"], step: int = 1
) -> Float[ndarray, " rows *columns"]:
    """Sum of x(k + i) weights(i) over i, for every `step`-th k whose window is whole.

    Args:
        x: (N, ...) samples, any unit.
        weights: (W,) in the order of the samples.
        step: Samples from one window to the next.

    Returns:
        ((N - W) // step + 1, ...) sums, none if N < W.
    """
    if len(x) < len(weights):
        return np.zeros((0, *x.shape[1:]))
    return sliding_window_view(x, len(weights), axis=0)[::step] @ weights
