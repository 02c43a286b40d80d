"""Gains as the literature finds them: by total least squares, and by instrumental variables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.load.current_equations import CurrentEquations


def references(
    equations: CurrentEquations, body: Float[ndarray, "10"]
) -> tuple[Float[ndarray, " joints"], Float[ndarray, " joints"]]:
    """Gains by total least squares and by instrumental variables, the load known whole.

    Both solve k_j i_j = (H beta)_j + (L phi)_j for k and beta. Total least squares take the last right
    singular vector of [H, -diag(i), L phi], whose noise they take for even; instruments are the same
    columns with the currents of a first, biased solution in place of the measured ones.

    Args:
        equations: Of the currents.
        body: The load about its joint's body frame, all ten parameters.
    """
    n = equations.joints
    rows, loads, currents = [], [], []
    for number, own in enumerate(equations.sets):
        plain = replace(own.model, has_load_friction=False)
        columns, _ = replace(own, model=plain).linearised(np.zeros(len(plain.names)))
        columns = columns.reshape(-1, n, columns.shape[1])
        base = len(plain.base)
        phi = body[list(plain.kept)] if number > 0 else np.zeros(len(plain.kept))
        rows.append(columns[:, :, :base])
        loads.append(columns[:, :, base:] @ phi)
        currents.append(own.torque)
    H, known, i = np.concatenate(rows), np.concatenate(loads), np.concatenate(currents)
    weight = 1 / np.sqrt(equations_residual(H, known, i))
    W = np.concatenate([H, -i[:, :, None] * np.eye(n)], axis=2) * weight[:, None]
    y = -(known * weight).reshape(-1)
    W = W.reshape(-1, W.shape[2])
    used = np.linalg.norm(W, axis=0)
    scale = np.where(used > 0, used, 1.0)
    joined = np.column_stack([W / scale, y])
    *_, right = np.linalg.svd(joined, full_matrices=False)
    last = right[-1]
    tls = -(last[:-1] / last[-1]) / scale
    first = np.linalg.lstsq(W / scale, y, rcond=None)[0] / scale
    modelled = (H @ first[:-n] + known) / first[-n:]
    Z = np.concatenate([H, -modelled[:, :, None] * np.eye(n)], axis=2) * weight[:, None]
    Z = Z.reshape(-1, Z.shape[2]) / scale
    iv = np.linalg.lstsq(Z.T @ (W / scale), Z.T @ y, rcond=None)[0] / scale
    return tls[-n:], iv[-n:]


def equations_residual(
    H: Float[ndarray, "samples joints base"],
    known: Float[ndarray, "samples joints"],
    i: Float[ndarray, "samples joints"],
) -> Float[ndarray, " joints"]:
    """(n,) mean squared residual of each joint by itself, by which rows are weighted."""
    found = []
    for j in range(i.shape[1]):
        columns = np.column_stack([H[:, j], known[:, j]])
        rest = i[:, j] - columns @ np.linalg.lstsq(columns, i[:, j], rcond=None)[0]
        found.append(np.mean(rest**2))
    return np.array(found)
