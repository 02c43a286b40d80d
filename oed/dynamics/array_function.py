"""CasADi functions of small matrices, called as often as an instant of a simulation asks for."""

from __future__ import annotations

from collections.abc import Callable

import casadi
import numpy as np
from numpy import ndarray


def array_function(function: casadi.Function) -> Callable[..., list[ndarray]]:
    """The function on arrays that it reads from and writes to as they lie.

    CasADi's own call makes a matrix of its kind of each argument and each result, which takes longer
    than most functions of one instant.

    Args:
        function: Of dense matrices.

    Returns:
        It, of arrays of the arguments' shapes, or of n numbers for n x 1; its results are new arrays.

    Raises:
        ValueError: If an argument is not dense.
    """
    buffer, trigger = function.buffer()
    arguments, results = [], []
    for k in range(function.n_in()):
        if not function.sparsity_in(k).is_dense():
            raise ValueError(f"{function.name()}: its argument {function.name_in(k)} is not dense")
        # CasADi stores matrices by columns.
        arguments.append(np.zeros(function.size_in(k)[::-1]))
        if arguments[k].size:
            buffer.set_arg(k, memoryview(arguments[k]))  # pyright: ignore[reportArgumentType, reportCallIssue]
    for k in range(function.n_out()):
        sparsity = function.sparsity_out(k)
        entries = np.zeros(sparsity.nnz())
        if entries.size:
            buffer.set_res(k, memoryview(entries))  # pyright: ignore[reportArgumentType, reportCallIssue]
        results.append((sparsity.shape, sparsity.get_triplet(), entries))

    def call(*values: ndarray) -> list[ndarray]:
        for argument, value in zip(arguments, values, strict=True):
            argument[...] = value.T
        # The trigger is a bare pointer: naming the buffer and its function keeps them alive.
        _ = function, buffer
        trigger()
        return [_laid_out(*result) for result in results]

    return call


def _laid_out(
    shape: tuple[int, int], places: tuple[list[int], list[int]], entries: ndarray
) -> ndarray:
    """The matrix of that shape, zero where it has no entries."""
    if entries.size == shape[0] * shape[1]:
        return entries.reshape(shape, order="F").copy()
    matrix = np.zeros(shape)
    matrix[places] = entries
    return matrix
