"""D-optimal weights on given atoms, under linear equalities: a primal-dual interior point."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg
from jaxtyping import Float
from numpy import ndarray

from oed.design.bound.deadline import NEVER, Deadline
from oed.errors import OedError

ITERATIONS = 100  # interior-point methods take some tens, whatever the size
TO_BOUNDARY = (
    0.9  # fraction of the step to the nearest weight's zero; usual in interior-point methods
)
CENTRING = 0.2  # of the mean complementarity; usual likewise
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
    deadline: Deadline = NEVER,
) -> WeightedDesign:
    """Maximise log det sum_i w_i F_i' F_i over w >= 0 with sum w = 1 and sum w_i b_i = 0.

    Args:
        factors: F_i, the regressor rows of each atom.
        balance: b_i, what has to cancel over all atoms.
        tolerance: On the mean complementarity and on the equalities.
        deadline: When to give up.

    Raises:
        WeightsNotFound: If it does not converge.
        OutOfTime: At the deadline.
    """
    scale = np.abs(balance).max(axis=0, initial=0.0)
    scale = np.where(scale > 0, scale, 1.0)
    equalities = np.column_stack([np.ones(len(factors)), balance / scale])
    iterate = _Iterate.first(factors, equalities)
    for _ in range(ITERATIONS):
        deadline.check()
        if iterate.is_optimal(tolerance, tolerance):
            break
        try:
            iterate = iterate.next()
        except np.linalg.LinAlgError:  # where no weights will do, all of them shrink to nothing
            break
    if not iterate.is_optimal(tolerance, NEARLY):
        raise WeightsNotFound(
            "no optimal weights found: equalities off by "
            f"{np.abs(iterate.primal).max():.1e}, complementarity {iterate.gap:.1e}",
            float(np.abs(iterate.primal).max()),
            iterate.gap,
        )
    y = iterate.multipliers
    return WeightedDesign(
        iterate.weights, iterate.information, float(y[0]), y[1:] / scale, iterate.gap
    )


@dataclass(frozen=True)
class _Iterate:
    """A point of the interior path: weights w, slacks z, multipliers y, and its residuals."""

    factors: Float[ndarray, "atoms rows columns"]
    equalities: Float[ndarray, "atoms all"]
    weights: Float[ndarray, " atoms"]
    slacks: Float[ndarray, " atoms"]
    multipliers: Float[ndarray, " all"]

    @classmethod
    def first(
        cls,
        factors: Float[ndarray, "atoms rows columns"],
        equalities: Float[ndarray, "atoms all"],
    ) -> _Iterate:
        """Equal weights; slacks and the mass's multiplier of the size they have at the optimum."""
        atoms, _, columns = factors.shape
        y = np.zeros(equalities.shape[1])
        y[0] = 2.0 * columns
        return cls(
            factors, equalities, np.full(atoms, 1 / atoms), np.full(atoms, float(columns)), y
        )

    @cached_property
    def information(self) -> Float[ndarray, "columns columns"]:
        """sum_i w_i F_i' F_i."""
        both = (self.weights, self.factors, self.factors)
        return np.einsum("i,irc,ird->cd", *both, optimize=True)

    @cached_property
    def whitened(self) -> Float[ndarray, "atoms rows columns"]:
        """Atoms in coordinates in which the information is the identity."""
        return _whiten(self.factors, self.information)

    @cached_property
    def dual(self) -> Float[ndarray, " atoms"]:
        """Residual of stationarity."""
        gradient = np.einsum("irc,irc->i", self.whitened, self.whitened)
        return -gradient + self.equalities @ self.multipliers - self.slacks

    @cached_property
    def primal(self) -> Float[ndarray, " all"]:
        """Residual of the equalities."""
        residual = self.equalities.T @ self.weights
        residual[0] -= 1.0
        return residual

    @property
    def gap(self) -> float:
        """Mean complementarity."""
        return float(self.weights @ self.slacks) / len(self.weights)

    def is_optimal(self, feasibility: float, loss: float) -> bool:
        """Whether the equalities hold, and at most a fraction `loss` of det^(1/p) is lost.

        The gap summed over the atoms is p times that loss.
        """
        columns = self.factors.shape[2]
        return bool(
            np.abs(self.primal).max() < feasibility
            and self.gap * len(self.weights) < loss * columns
            and np.abs(self.dual).max() < loss / DUAL_SLACK * columns
        )

    def next(self) -> _Iterate:
        """One Newton step towards a smaller gap, as far as weights and slacks stay positive."""
        complementarity = self.weights * self.slacks - CENTRING * self.gap
        dw, dz, dy = _direction(
            self.weights,
            self.slacks,
            (self.dual, self.primal, complementarity),
            self.equalities,
            _curvature(self.whitened),
        )
        step = min(_longest(self.weights, dw), _longest(self.slacks, dz))
        return replace(
            self,
            weights=self.weights + step * dw,
            slacks=self.slacks + step * dz,
            multipliers=self.multipliers + step * dy,
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
    solution = np.linalg.lstsq(system, load, rcond=1e-15)[0]
    dw = inverse * (right - both @ solution)
    dz = (-complementarity - z * dw) / w
    return dw, dz, solution[:count]


def _longest(values: ndarray, direction: ndarray) -> float:
    falling = direction < 0
    longest = (-values[falling] / direction[falling]).min(initial=np.inf)
    return float(min(1.0, TO_BOUNDARY * longest))
