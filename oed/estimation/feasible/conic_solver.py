"""The problem by a conic solver, through CVXPY."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Literal

import cvxpy as cp
import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import block_diag

from oed.estimation.feasible.coordinates import BASIS, ENTRIES, IDENTITY
from oed.estimation.feasible.interior import SolverFailed, solve_quietly
from oed.estimation.feasible.optimality import Multipliers
from oed.estimation.feasible.problem import FeasibleProblem
from oed.estimation.feasible.regularisation import quadratic_root

ConicSolver = Literal["clarabel", "scs"]
# First-order steps to eight digits: about a hundred times the work of the default accuracy.
SCS_SETTINGS = {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iters": 50_000}
CLARABEL_SETTINGS = {"tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10, "tol_feas": 1e-10}


@dataclass(frozen=True)
class SolverResult:
    """What a solver says.

    Attributes:
        x: (p,) unknowns.
        multipliers: Prices of the demands.
        solver: Its name.
        status: In its own words.
        iterations: It took.
        seconds: Wall time, setting up included.
    """

    x: Float[ndarray, " p"]
    multipliers: Multipliers
    solver: str
    status: str
    iterations: int
    seconds: float


def solve_conic(
    problem: FeasibleProblem,
    solver: ConicSolver = "clarabel",
    *,
    at: Float[ndarray, " p"] | None = None,
) -> SolverResult:
    """Solve by Clarabel (interior point) or SCS (first order).

    A solver's tolerances are those of numbers around one. The objective is divided by its
    value at `at`, and links are measured there: J^ = L Y L^T with L L^T = J^(at), so that Y is
    the identity at that point, however far from the reference bodies it lies. Without a point
    the objective is as it is: about one at the solution, since the data are weighted.

    Args:
        problem: To solve.
        solver: By which.
        at: A point near the solution whose J^ are positive definite; the reference if None.

    Raises:
        SolverFailed: If there is no solution to look at.
    """
    start = time.perf_counter()
    point = problem.coordinates.start if at is None else at
    roots = np.linalg.cholesky(problem.coordinates.relative_inertias(point))
    size = 1.0 if at is None else problem.size(at)
    y, to_unknowns, links, rows, program = _build(problem, roots, size)
    settings = CLARABEL_SETTINGS if solver == "clarabel" else SCS_SETTINGS
    try:
        solve_quietly(program, solver.upper(), **settings)
    except cp.SolverError as error:
        raise SolverFailed("no solution", (f"{solver}: {error}",)) from error
    if y.value is None:
        raise SolverFailed("no solution", (f"{solver}: {program.status}",))
    prices = np.atleast_1d(np.asarray(rows[0].dual_value)) if rows else np.zeros(0)
    turned = np.linalg.inv(roots)
    duals = np.array([link.dual_value for link in links])
    return SolverResult(
        x=to_unknowns @ np.asarray(y.value, dtype=float),
        multipliers=Multipliers(size * turned.transpose(0, 2, 1) @ duals @ turned, size * prices),
        solver=solver,
        status=str(program.status),
        iterations=int(program.solver_stats.num_iters or 0),
        seconds=time.perf_counter() - start,
    )


def _build(
    problem: FeasibleProblem, roots: Float[ndarray, "links 4 4"], size: float
) -> tuple[
    cp.Variable,
    Float[ndarray, "p p"],
    list[cp.Constraint],
    list[cp.Constraint],
    cp.Problem,
]:
    coordinates, regularisation = problem.coordinates, problem.regularisation
    inertial = ENTRIES * coordinates.links
    blocks = [
        np.einsum("aij,kij->ak", BASIS, root @ BASIS @ root.T).reshape(ENTRIES, ENTRIES)
        for root in roots
    ]
    to_unknowns = np.asarray(block_diag(*blocks, np.eye(coordinates.size - inertial)))
    y = cp.Variable(coordinates.size)
    spread = BASIS.reshape(ENTRIES, 16).T
    matrices = [
        cp.reshape(spread @ y[ENTRIES * i : ENTRIES * i + ENTRIES], (4, 4), order="C")
        for i in range(coordinates.links)
    ]
    objective = cp.sum_squares(problem.factor @ to_unknowns @ y - problem.target)
    effects = y[inertial:]
    if effects.size:
        objective += problem.tie_break[-1] / 2 * cp.sum_squares(effects)
    if regularisation.kind == "entropic":
        # log det J^ is log det Y and a constant.
        traces = (np.tile(IDENTITY, coordinates.links) @ to_unknowns[:inertial, :inertial]) @ y[
            :inertial
        ]
        distance = traces - cp.sum([cp.log_det(matrix) for matrix in matrices])
    else:
        root = quadratic_root(coordinates)
        distance = cp.sum_squares(root @ (to_unknowns @ y - coordinates.start)) / 2
    least = [problem.margin * np.linalg.inv(root.T @ root) for root in roots]
    links: list[cp.Constraint] = [Y >> Z for Y, Z in zip(matrices, least, strict=True)]
    rows = [problem.inequality.matrix @ to_unknowns @ y >= problem.inequality.bound]
    equal = [problem.equality.matrix @ to_unknowns @ y == problem.equality.bound]
    rows, equal = rows[: len(problem.inequality)], equal[: len(problem.equality)]
    minimise = cp.Minimize((objective + regularisation.weight * distance) / size)
    return y, to_unknowns, links, rows, cp.Problem(minimise, [*links, *rows, *equal])
