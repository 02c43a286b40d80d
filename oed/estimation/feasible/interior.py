"""The most interior point of a set of links, or a proof that there is none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.feasible.cone_program import (
    ConeProgram,
    ConeRows,
    ConeSolution,
    ConicSolver,
    SolverFailed,
    solve_cones,
)
from oed.estimation.feasible.coordinates import BASIS, ENTRIES, IDENTITY, Coordinates, adjoint
from oed.estimation.feasible.feasible_set import Rows

# A weight below this share of the certificate takes no part in a contradiction.
TAKES_PART = 1e-3
# An interior-point method as it comes, else a first-order one, which hardly ever stops early: to
# five digits, of which a message tells two.
SOLVERS: Mapping[ConicSolver, Mapping[str, float]] = {
    "clarabel": {},
    "scs": {"eps_abs": 1e-5, "eps_rel": 1e-5},
}


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
    solution = _solve(_program(coordinates, inequality, equality))
    found = solution.x[:-1]
    slack = inequality.matrix @ found - inequality.bound
    eigenvalues = np.linalg.eigvalsh(coordinates.relative_inertias(found))
    duals = np.tensordot(solution.semidefinite.reshape(-1, ENTRIES), BASIS, axes=1)
    return Interior(
        x=found,
        margin=float(min(1.0, eigenvalues.min(), np.min(slack, initial=1.0))),
        certificate=_certificate(
            duals, solution.nonnegative[: len(inequality)], inequality, equality, coordinates
        ),
    )


def _program(coordinates: Coordinates, inequality: Rows, equality: Rows) -> ConeProgram:
    """The program in x and the margin, which is the last variable and at most one."""
    size, inertial = coordinates.size, ENTRIES * coordinates.links
    margin = np.eye(size + 1)[-1]
    links = np.eye(inertial, size + 1) - np.outer(np.tile(IDENTITY, coordinates.links), margin)
    rows = np.hstack([inequality.matrix, -np.ones((len(inequality), 1))])
    return ConeProgram(
        quadratic=np.zeros(size + 1),
        linear=-margin,
        zero=ConeRows(np.hstack([-equality.matrix, np.zeros((len(equality), 1))]), -equality.bound),
        nonnegative=ConeRows(np.vstack([-rows, margin]), np.append(-inequality.bound, 1.0)),
        semidefinite=ConeRows(-links, np.zeros(inertial)),
        orders=(4,) * coordinates.links,
        exponential=ConeRows.none(size + 1),
    )


def _solve(program: ConeProgram) -> ConeSolution:
    attempts: list[str] = []
    for solver, settings in SOLVERS.items():
        try:
            solution = solve_cones(program, solver, settings)
        except SolverFailed as failure:
            attempts += failure.attempts
            continue
        if solution.is_solved:
            return solution
        attempts.append(f"{solver}: {solution.status}")
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
