"""D-optimal weights on given atoms, under linear equalities: a primal-dual interior point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from jaxtyping import Float
from numpy import ndarray

from oed.errors import OedError

ITERATIONS = 100
TO_BOUNDARY = 0.9  # fraction of the step to the nearest weight's zero
CENTRING = 0.2  # of the mean complementarity
# The multipliers need no more digits: a proof over all states checks them afterwards.
DUAL_SLACK = 1e-3
# Rounding can end progress early. Weights this close to optimal [relative to the number of
# parameters] are good enough: what they lack only loosens a bound, and is in its excess.
NEARLY = 1e-4
REGULARISATION = 1e-13  # of the reduced system's diagonal: equalities may depend on each other


class WeightsNotFound(OedError):
    """The interior point did not converge: most likely no weights satisfy the equalities.

    Attributes:
        residual: Violation of the equalities where it stopped.
        gap: Mean complementarity there.
    """

    def __init__(self, message: str, residual: float, gap: float) -> None:
        super().__init__(message)
        self.residual = residual
        self.gap = gap


@dataclass(frozen=True)
class WeightedDesign:
    """D-optimal weights and the certificate that they are.

    Attributes:
        weights: (atoms,) at least 0, summing to 1.
        information: (p, p) sum of weight times atom.
        mass_multiplier: Multiplier of the sum of the weights; p at the optimum.
        multipliers: (m,) of the other equalities: tr(information^-1 A_i) - multipliers . b_i
            is at most `mass_multiplier` for every atom i.
        gap: Mean complementarity that is left.
    """

    weights: Float[ndarray, " atoms"]
    information: Float[ndarray, "columns columns"]
    mass_multiplier: float
    multipliers: Float[ndarray, " equalities"]
    gap: float


def optimal_weights(
    factors: Float[ndarray, "atoms rows columns"],
    balance: Float[ndarray, "atoms equalities"],
    *,
    tolerance: float = 1e-7,
) -> WeightedDesign:
    """Maximise log det sum_i w_i F_i' F_i over w >= 0 with sum w = 1 and sum w_i b_i = 0.

    Args:
        factors: F_i, the regressor rows of each atom.
        balance: b_i, what has to cancel over all atoms.
        tolerance: On the mean complementarity and on the equalities.

    Raises:
        WeightsNotFound: If it does not converge.
    """
    atoms, _, columns = factors.shape
    scale = np.abs(balance).max(axis=0, initial=0.0)
    scale = np.where(scale > 0, scale, 1.0)
    equalities = np.column_stack([np.ones(atoms), balance / scale])
    target = np.zeros(equalities.shape[1])
    target[0] = 1.0
    w, z, y = np.full(atoms, 1 / atoms), np.full(atoms, float(columns)), np.zeros(len(target))
    y[0] = 2.0 * columns
    for _ in range(ITERATIONS):
        information = np.einsum("i,irc,ird->cd", w, factors, factors, optimize=True)
        whitened = _whiten(factors, information)
        gradient = np.einsum("irc,irc->i", whitened, whitened)
        dual = -gradient + equalities @ y - z
        primal = equalities.T @ w - target
        gap = float(w @ z) / atoms
        # Complementarity is w z, summed: p times the relative gap of det^(1/p).
        is_optimal = max(gap * atoms, np.abs(dual).max() * DUAL_SLACK) < tolerance * columns
        if is_optimal and np.abs(primal).max() < tolerance:
            return WeightedDesign(w, information, float(y[0]), y[1:] / scale, gap)
        dw, dz, dy = _direction(
            w, z, (dual, primal, w * z - CENTRING * gap), equalities, _curvature(whitened)
        )
        step = min(_longest(w, dw), _longest(z, dz))
        w, z, y = w + step * dw, z + step * dz, y + step * dy
    residual = float(np.abs(primal).max())
    if residual < tolerance and gap * atoms < NEARLY * columns:
        return WeightedDesign(w, information, float(y[0]), y[1:] / scale, gap)
    raise WeightsNotFound(
        f"no optimal weights after {ITERATIONS} iterations: equalities off by {residual:.1e}, "
        f"complementarity {gap:.1e}",
        residual,
        gap,
    )


def _whiten(
    factors: Float[ndarray, "atoms rows columns"], information: Float[ndarray, "columns columns"]
) -> Float[ndarray, "atoms rows columns"]:
    """F_i L^-T with information = L L'."""
    atoms, rows, columns = factors.shape
    factor = np.linalg.cholesky(information)
    flat = factors.reshape(-1, columns)
    return scipy.linalg.solve_triangular(factor, flat.T, lower=True).T.reshape(atoms, rows, columns)


def _curvature(whitened: Float[ndarray, "atoms rows columns"]) -> Float[ndarray, "atoms pairs"]:
    """V with V V' the Hessian of -log det: whitened atoms as vectors, off-diagonals twice."""
    columns = whitened.shape[2]
    first, second = np.triu_indices(columns)
    weight = np.where(first == second, 1.0, np.sqrt(2.0))
    return np.einsum("irk,irk->ik", whitened[:, :, first], whitened[:, :, second]) * weight


def _direction(
    w: Float[ndarray, " atoms"],
    z: Float[ndarray, " atoms"],
    residuals: tuple[ndarray, ndarray, ndarray],
    equalities: Float[ndarray, "atoms all"],
    curvature: Float[ndarray, "atoms pairs"],
) -> tuple[ndarray, ndarray, ndarray]:
    """Newton direction of weights, slacks and multipliers.

    The Hessian is of low rank: with u = V' dw the system shrinks to equalities plus pairs.
    """
    dual, primal, complementarity = residuals
    both = np.concatenate([equalities, curvature], axis=1)
    inverse = w / z
    right = -dual - complementarity / w
    system = both.T @ (inverse[:, None] * both)
    count = equalities.shape[1]
    system[np.arange(count, len(system)), np.arange(count, len(system))] += 1.0
    system[np.diag_indices(len(system))] *= 1 + REGULARISATION
    load = both.T @ (inverse * right)
    load[:count] += primal
    solution = scipy.linalg.lstsq(system, load, cond=1e-15, lapack_driver="gelsy")[0]
    dw = inverse * (right - both @ solution)
    dz = (-complementarity - z * dw) / w
    return dw, dz, solution[:count]


def _longest(values: ndarray, direction: ndarray) -> float:
    falling = direction < 0
    longest = (-values[falling] / direction[falling]).min(initial=np.inf)
    return float(min(1.0, TO_BOUNDARY * longest))
