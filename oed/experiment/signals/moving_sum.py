"""Weighted sums over the windows of a signal: a finite impulse response, of few rows if need be."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray


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
    return windows(x, len(weights), step) @ weights


def windows(
    x: Float[ndarray, " samples *columns"], length: int, step: int = 1
) -> Float[ndarray, " rows *columns length"]:
    """Every `step`-th whole window of a signal, a view where its columns are contiguous or its rows.

    NumPy's own views of windows cost more than the sums over them.
    """
    x = x if x.flags.forc else np.ascontiguousarray(x)
    buffer = x if x.flags.c_contiguous else x.T
    sample, rest = x.strides[0], x.strides[1:]
    shape = ((len(x) - length) // step + 1, *x.shape[1:], length)
    return np.ndarray(shape, x.dtype, buffer, 0, (step * sample, *rest, sample))
