"""The most interior point of a set of links, or a proof that there is none."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import cvxpy as cp
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.errors import OedError
from oed.estimation.feasible.coordinates import BASIS, ENTRIES, Coordinates, adjoint
from oed.estimation.feasible.feasible_set import Rows

# A weight below this share of the certificate takes no part in a contradiction.
TAKES_PART = 1e-3
SOLVED = ("optimal", "optimal_inaccurate")


class SolverFailed(OedError):
    """No solver came to a solution that passes its own check.

    Attributes:
        attempts: Solver and outcome, one line each.
    """

    def __init__(self, message: str, attempts: tuple[str, ...]) -> None:
        super().__init__(f"{message}: {'; '.join(attempts)}")
        self.attempts = attempts


@dataclass(frozen=True)
class Certificate:
    """Weights whose combination of all demands is a constant: a bound on any margin.

    For every x that obeys the equalities, sum_i <Y_i, J^_i> + y (C x - d) = bound, with Y_i
    positive semidefinite, y not negative, and traces and y adding up to one. So no x has a
    margin above `bound`; if that is negative, none is feasible.

    Attributes:
        bound: Upper bound on the margin.
        links: (n,) trace of each Y_i: the share of each link in the bound.
        inequality: (k,) share of each inequality row.
        equality: (m,) price of each equality row.
        residual: How far the combination is from constant, recomputed: of a unit vector.
        matrices: (n, 4, 4) Y_i, for whoever checks the proof.
    """

    bound: float
    links: Float[ndarray, " links"]
    inequality: Float[ndarray, " k"]
    equality: Float[ndarray, " m"]
    residual: float
    matrices: Float[ndarray, "links 4 4"]


@dataclass(frozen=True)
class Interior:
    """The most interior point.

    Attributes:
        x: (p,) its unknowns.
        margin: Least of all eigenvalues of J^_i and slacks of rows there, recomputed; at most 1.
        certificate: That no point has a larger one.
    """

    x: Float[ndarray, " p"]
    margin: float
    certificate: Certificate


def most_interior(coordinates: Coordinates, inequality: Rows, equality: Rows) -> Interior:
    """Maximise the least eigenvalue of J^_i and slack of the inequality rows.

    Args:
        coordinates: Of the unknowns.
        inequality: C x >= d, rows of unit length.
        equality: C x = d, likewise.

    Raises:
        SolverFailed: If the solver finds neither a point nor a bound.
    """
    x, margin = cp.Variable(coordinates.size), cp.Variable()
    matrices = [
        cp.reshape(
            BASIS.reshape(ENTRIES, 16).T @ x[ENTRIES * i : ENTRIES * i + ENTRIES], (4, 4), order="C"
        )
        for i in range(coordinates.links)
    ]
    links = [matrix >> margin * np.eye(4) for matrix in matrices]
    rows = [inequality.matrix @ x - inequality.bound >= margin] if len(inequality) else []
    equal = [equality.matrix @ x == equality.bound] if len(equality) else []
    problem = cp.Problem(cp.Maximize(margin), [*links, *rows, *equal, margin <= 1.0])
    _solve(problem)
    found = np.asarray(x.value)
    slack = inequality.matrix @ found - inequality.bound
    eigenvalues = np.linalg.eigvalsh(coordinates.relative_inertias(found))
    prices = np.asarray(rows[0].dual_value) if rows else np.zeros(0)
    return Interior(
        x=found,
        margin=float(min(1.0, eigenvalues.min(), np.min(slack, initial=1.0))),
        certificate=_certificate(
            np.array([link.dual_value for link in links]),
            np.atleast_1d(prices),
            inequality,
            equality,
            coordinates,
        ),
    )


def solve_quietly(problem: cp.Problem, solver: str, **settings: int | float) -> None:
    """Solve without a warning of a doubtful solution: the status says so, and it is checked."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Solution may be inaccurate")
        problem.solve(solver=solver, **settings)


def _solve(problem: cp.Problem) -> None:
    """By an interior-point method, else by a first-order one, which hardly ever stops early."""
    attempts = []
    for solver in ("CLARABEL", "SCS"):
        try:
            solve_quietly(problem, solver)
        except cp.SolverError as error:
            attempts.append(f"{solver.lower()}: {error}")
            continue
        if problem.status in SOLVED:
            return
        attempts.append(f"{solver.lower()}: {problem.status}")
    raise SolverFailed("no most interior point", tuple(attempts))


def _certificate(
    duals: Float[ndarray, "links 4 4"],
    prices: Float[ndarray, " k"],
    inequality: Rows,
    equality: Rows,
    coordinates: Coordinates,
) -> Certificate:
    values, vectors = np.linalg.eigh(duals)
    links = np.einsum("lij,lj,lkj->lik", vectors, np.maximum(values, 0.0), vectors)
    prices = np.maximum(prices, 0.0)
    total = float(np.trace(links, axis1=1, axis2=2).sum() + prices.sum())
    if total <= TAKES_PART:
        # The cap of the margin is all that binds: every demand can be exceeded by one.
        none = np.zeros(len(equality))
        return Certificate(
            1.0, np.zeros(len(links)), np.zeros(len(prices)), none, 0.0, np.zeros_like(links)
        )
    links, prices = links / total, prices / total
    combined = np.zeros(coordinates.size)
    combined[: ENTRIES * coordinates.links] = adjoint(links)
    combined += inequality.matrix.T @ prices
    across = equality.matrix.T
    price = np.linalg.lstsq(across, combined, rcond=None)[0] if len(equality) else np.zeros(0)
    left = combined - across @ price
    return Certificate(
        bound=float(price @ equality.bound - prices @ inequality.bound),
        links=np.trace(links, axis1=1, axis2=2),
        inequality=prices,
        equality=price,
        residual=float(np.linalg.norm(left)),
        matrices=links,
    )
