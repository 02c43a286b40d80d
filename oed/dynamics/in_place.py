"""CasADi functions of small matrices, called as often as an instant of a simulation asks for."""

from __future__ import annotations

from collections.abc import Callable

import casadi
import numpy as np
from numpy import ndarray


def in_place(function: casadi.Function) -> Callable[..., list[ndarray]]:
    """The function on arrays that it reads from and writes to as they lie.

    CasADi's own call makes a matrix of its kind of each argument and each result, which takes longer
    than most functions of one instant.

    Args:
        function: Of dense matrices, to dense matrices.

    Returns:
        It, of arrays of the arguments' shapes, or of n numbers for n x 1; its results are new arrays.

    Raises:
        ValueError: If a matrix is not dense.
    """
    count = function.n_in()
    sparsities = [function.sparsity_in(k) for k in range(count)]
    sparsities += [function.sparsity_out(k) for k in range(function.n_out())]
    if not all(sparsity.is_dense() for sparsity in sparsities):
        raise ValueError(f"{function.name()}: not all of its matrices are dense")
    # CasADi stores matrices by columns.
    held = [np.zeros((s.size2(), s.size1())) for s in sparsities]
    buffer, trigger = function.buffer()
    for k, array in enumerate(held):
        if k < count and array.size:
            buffer.set_arg(k, memoryview(array))  # pyright: ignore[reportArgumentType, reportCallIssue]
        elif array.size:
            buffer.set_res(k - count, memoryview(array))  # pyright: ignore[reportArgumentType, reportCallIssue]

    def call(*values: ndarray) -> list[ndarray]:
        for array, value in zip(held[:count], values, strict=True):
            array[...] = value.T
        # The trigger is a bare pointer: naming the buffer and its function keeps them alive.
        _ = function, buffer
        trigger()
        return [array.T.copy() for array in held[count:]]

    return call
