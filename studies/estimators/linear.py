"""Estimators of linear equations: least squares, total least squares, ridge, truncated SVD."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from studies.estimators.recipe import Equations, Found

FOLDS = 5  # of the cross-validation in time
RIDGES = tuple(np.logspace(-8, 0, 17))  # of the largest singular value squared
TRUNCATIONS = tuple(np.logspace(-5, -0.5, 19))  # of the largest singular value
Fit = Callable[[Float[ndarray, "rows base"], Float[ndarray, " rows"]], Float[ndarray, " base"]]


def ordinary(equations: Equations) -> Found:
    """Weighted least squares with the deviations of white noise (IDIM-LS)."""
    e = equations.weighted()
    scale = np.linalg.norm(e.W, axis=0)
    _, s, right = np.linalg.svd(e.W / scale, full_matrices=False)
    parameters = np.linalg.lstsq(e.W / scale, e.y, rcond=None)[0] / scale
    variance = np.sum((e.y - e.W @ parameters) ** 2) / (len(e.y) - len(scale))
    spread = np.sqrt(variance * np.sum((right / s[:, None]) ** 2, axis=0)) / scale
    return Found.of_std(parameters, spread)


def total(equations: Equations) -> Found:
    """Total least squares: the last right singular vector of [W, y], columns of one length."""
    e = equations.weighted()
    scale = np.linalg.norm(e.W, axis=0)
    joined = np.column_stack([e.W / scale, e.y / np.linalg.norm(e.y)])
    *_, right = np.linalg.svd(joined, full_matrices=False)
    last = right[-1]
    return Found.bare(-last[:-1] / last[-1] * np.linalg.norm(e.y) / scale)


def ridge(equations: Equations) -> Found:
    """Ridge regression; its weight by cross-validation in time."""
    return _validated(equations, [_ridge(share) for share in RIDGES])


def truncated(equations: Equations) -> Found:
    """Truncated singular value decomposition; its threshold by cross-validation in time."""
    return _validated(equations, [_truncated(share) for share in TRUNCATIONS])


def _ridge(share: float) -> Fit:
    def fit(W: Float[ndarray, "rows base"], y: Float[ndarray, " rows"]) -> Float[ndarray, " base"]:
        left, s, right = np.linalg.svd(W, full_matrices=False)
        return right.T @ (s / (s**2 + share * s[0] ** 2) * (left.T @ y))

    return fit


def _truncated(share: float) -> Fit:
    def fit(W: Float[ndarray, "rows base"], y: Float[ndarray, " rows"]) -> Float[ndarray, " base"]:
        left, s, right = np.linalg.svd(W, full_matrices=False)
        kept = s > share * s[0]
        return right[kept].T @ ((left.T @ y)[kept] / s[kept])

    return fit


def _validated(equations: Equations, fits: Sequence[Fit]) -> Found:
    """The fit that predicts stretches of time best that it has not seen, made of all rows."""
    e = equations.weighted()
    scale = np.linalg.norm(e.W, axis=0)
    W, y = e.W / scale, e.y
    stretches = np.array_split(np.arange(len(y) // e.joints), FOLDS)
    rows = [np.ravel(s[:, None] * e.joints + np.arange(e.joints)) for s in stretches]

    def error(fit: Fit) -> float:
        left = (np.setdiff1d(np.arange(len(y)), out) for out in rows)
        return sum(
            float(np.sum((y[out] - W[out] @ fit(W[kept], y[kept])) ** 2))
            for out, kept in zip(rows, left, strict=True)
        )

    best = min(fits, key=error)
    return Found.bare(best(W, y) / scale)
