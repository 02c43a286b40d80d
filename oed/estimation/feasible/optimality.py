"""Whether a point is feasible and optimal, from its own numbers and not a solver's word."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import null_space

from oed.estimation.feasible.coordinates import ENTRIES, adjoint
from oed.estimation.feasible.problem import FeasibleProblem

TOLERANCE = 1e-6
# Relative to the link's reference body: the rounding of an interior-point solver's last step.
FEASIBLE_TO = 1e-9


@dataclass(frozen=True)
class Multipliers:
    """Prices of the demands.

    Attributes:
        links: (n, 4, 4) of J^_i >= margin I, positive semidefinite.
        inequality: (k,) of the inequality rows, not negative.
    """

    links: Float[ndarray, "links 4 4"]
    inequality: Float[ndarray, " k"]


@dataclass(frozen=True)
class Optimality:
    """The Karush-Kuhn-Tucker conditions, evaluated.

    Attributes:
        primal: Largest violation of a demand, relative to the reference bodies.
        decrement: By how much the Lagrangian could still fall: half r^T H^-1 r for the gradient
            r of the objective less priced demands and the objective's Hessian H, relative
            to the objective. Unlike the length of r it depends on no scaling.
        gap: What complementarity leaves between objective and Lagrangian, relative to the
            objective. With the decrement it bounds how far the objective is from optimal.
    """

    primal: float
    decrement: float
    gap: float

    @property
    def suboptimality(self) -> float:
        """Bound on how far the objective is above its optimum, relative to it."""
        return self.decrement + self.gap

    def holds(self, tolerance: float = TOLERANCE) -> bool:
        """Whether the point is feasible and optimal to a relative tolerance."""
        return self.primal <= FEASIBLE_TO and self.suboptimality <= tolerance


def check_optimality(
    problem: FeasibleProblem, x: Float[ndarray, " p"], multipliers: Multipliers
) -> Optimality:
    """Evaluate the optimality conditions at a point.

    Multipliers are first projected onto their cones, so that they bound the objective from
    below whatever their origin; those of equalities are not needed, because the Lagrangian is
    looked at within the equalities alone.

    Args:
        problem: That x is to solve.
        x: Unknowns.
        multipliers: A solver's prices of the demands.
    """
    values, vectors = np.linalg.eigh(multipliers.links)
    positive = np.maximum(values, 0.0)
    links = np.einsum("lij,lj,lkj->lik", vectors, positive, vectors)
    prices = np.maximum(multipliers.inequality, 0.0)
    priced = np.zeros(len(x))
    priced[: ENTRIES * problem.coordinates.links] = adjoint(links)
    priced += problem.inequality.matrix.T @ prices
    rest = problem.gradient(x) - priced
    slack = problem.coordinates.relative_inertias(x) - problem.margin * np.eye(4)
    gap = float(np.sum(links * slack) + prices @ problem.slack(x))
    return Optimality(
        primal=primal_violation(problem, x),
        decrement=_decrement(problem, x, rest) / problem.size(x),
        gap=abs(gap) / problem.size(x),
    )


def _decrement(
    problem: FeasibleProblem, x: Float[ndarray, " p"], rest: Float[ndarray, " p"]
) -> float:
    hessian = problem.hessian(x)
    if len(problem.equality):
        free = null_space(problem.equality.matrix)
        rest, hessian = free.T @ rest, free.T @ hessian @ free
    scale = 1 / np.sqrt(np.diag(hessian))
    values, vectors = np.linalg.eigh(hessian * np.outer(scale, scale))
    along = vectors.T @ (scale * rest)
    # A curvature below rounding is taken as rounding: it can only make the decrement smaller
    # where no number is left to tell.
    return float(0.5 * np.sum(along**2 / np.maximum(values, np.finfo(float).eps)))


def primal_violation(problem: FeasibleProblem, x: Float[ndarray, " p"]) -> float:
    """Largest violation of a demand; 0 for a feasible point."""
    violations = [
        float(np.max(problem.margin - problem.link_margins(x))),
        float(np.max(-problem.slack(x), initial=0.0)),
        float(np.max(np.abs(problem.equality.matrix @ x - problem.equality.bound), initial=0.0)),
    ]
    return max(0.0, *violations)
