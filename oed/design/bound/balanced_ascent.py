"""D-optimal weights on many atoms under linear equalities, by entropic mirror ascent.

For tens of parameters Newton's method has thousands of unknowns; this first-order method costs
one pass over the atoms a step. Without equalities, and to first order, a step is the
multiplicative algorithm w_i <- w_i g_i / b (Silvey, Titterington and Torsney 1978); with them it
is followed by the projection, in Kullback-Leibler divergence, onto the weights that satisfy them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from jaxtyping import Float
from numpy import ndarray

from oed.design.bound.deadline import NEVER, Deadline

PROJECTION_STEPS = 30  # of Newton; two or three suffice where the weights were balanced before
BALANCED = 1e-9  # what the weighted mean of the scaled equalities may be off by
DAMPING = 1e-10  # of Newton's matrix: equalities may depend on each other
HALVINGS = 30  # of a step that gains nothing: to a billionth


@dataclass(frozen=True)
class AscentPoint:
    """Weights after some steps, and what they say.

    Attributes:
        weights: (atoms,) positive, summing to 1.
        information: (b, b) sum of weight times atom.
        multipliers: (m,) y of the equalities: at the optimum g_i - y . b_i is at most b, with
            g_i the gradient of log det by weight i.
        imbalance: Largest weighted mean of an equality, each in units of its largest entry.
    """

    weights: Float[ndarray, " atoms"]
    information: Float[ndarray, "columns columns"]
    multipliers: Float[ndarray, " equalities"]
    imbalance: float


def ascend(
    factors: Float[ndarray, "atoms rows columns"],
    balance: Float[ndarray, "atoms equalities"],
    weights: Float[ndarray, " atoms"],
    *,
    steps: int,
    deadline: Deadline = NEVER,
) -> AscentPoint:
    """Raise log det sum_i w_i F_i' F_i over w >= 0 with sum w = 1 and sum w_i b_i = 0.

    Args:
        factors: F_i, the regressor rows of each atom.
        balance: b_i, what has to cancel over all atoms.
        weights: To start from; positive, not necessarily balanced.
        steps: How many.
        deadline: When to give up.

    Raises:
        OutOfTime: At the deadline.
    """
    scale = np.abs(balance).max(axis=0, initial=0.0)
    scale = np.where(scale > 0, scale, 1.0)
    scaled = balance / scale
    columns = factors.shape[2]
    weights, _ = project(weights, scaled)
    y = np.zeros(balance.shape[1])
    for _ in range(steps):
        deadline.check()
        gain = gradient(factors, information_of(factors, weights))
        # The exponent of a step is the gradient over b: its mean over the weights is 1.
        weights, y = project(weights * np.exp(gain / columns - gain.max() / columns), scaled)
    imbalance = float(np.abs(weights @ scaled).max(initial=0.0))
    return AscentPoint(weights, information_of(factors, weights), columns * y / scale, imbalance)


def information_of(
    factors: Float[ndarray, "atoms rows columns"], weights: Float[ndarray, " atoms"]
) -> Float[ndarray, "columns columns"]:
    """sum_i w_i F_i' F_i."""
    rows = (factors * np.sqrt(weights)[:, None, None]).reshape(-1, factors.shape[2])
    return rows.T @ rows


def gradient(
    factors: Float[ndarray, "atoms rows columns"], information: Float[ndarray, "columns columns"]
) -> Float[ndarray, " atoms"]:
    """tr(information^-1 F_i' F_i) of each atom: the gradient of log det by its weight."""
    atoms, rows, columns = factors.shape
    lower = np.linalg.cholesky(information)
    whitener = scipy.linalg.solve_triangular(lower, np.eye(columns), lower=True)
    white = factors.reshape(-1, columns) @ whitener.T
    return np.einsum("rc,rc->r", white, white).reshape(atoms, rows).sum(axis=1)


def project(
    weights: Float[ndarray, " atoms"], balance: Float[ndarray, "atoms equalities"]
) -> tuple[Float[ndarray, " atoms"], Float[ndarray, " equalities"]]:
    """The nearest weights, in Kullback-Leibler divergence, that sum to 1 and balance.

    They are w_i exp(-y . b_i), y the least of a convex function; Newton's method with halving.

    Returns:
        The weights and y. Where no weights balance, those at which Newton's method ends.
    """
    weights = weights / weights.sum()
    y = np.zeros(balance.shape[1])
    logs = np.log(weights, out=np.full_like(weights, -np.inf), where=weights > 0)
    value, tilted = _tilt(logs, balance, y)
    for _ in range(PROJECTION_STEPS):
        mean = tilted @ balance
        if np.abs(mean).max(initial=0.0) <= BALANCED:
            break
        curvature = (balance * tilted[:, None]).T @ balance - np.outer(mean, mean)
        curvature[np.diag_indices(len(mean))] += DAMPING * max(np.trace(curvature), 1e-300)
        direction = np.linalg.solve(curvature, mean)
        slope = float(direction @ mean)
        step = 1.0
        for _ in range(HALVINGS):
            candidate, moved = _tilt(logs, balance, y + step * direction)
            if candidate <= value - 1e-4 * step * slope:
                break
            step /= 2
        else:
            break
        y, value, tilted = y + step * direction, candidate, moved
    return tilted, y


def _tilt(
    logs: Float[ndarray, " atoms"],
    balance: Float[ndarray, "atoms equalities"],
    y: Float[ndarray, " equalities"],
) -> tuple[float, Float[ndarray, " atoms"]]:
    """Log sum w exp(-y . b), and the weights w exp(-y . b) made to sum to 1."""
    exponent = logs - balance @ y
    top = exponent.max()
    raised = np.exp(exponent - top)
    total = raised.sum()
    # A weight of zero would never return; the smallest positive number does no harm.
    return float(top + np.log(total)), np.maximum(raised / total, np.finfo(float).tiny)
