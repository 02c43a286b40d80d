"""The problem by a conic solver, through CVXPY."""

from __future__ import annotations

import time
import warnings
from dataclasses import dataclass
from typing import Literal

import cvxpy as cp
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.feasible.coordinates import BASIS, ENTRIES, IDENTITY
from oed.estimation.feasible.interior import SolverFailed
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


def solve_conic(problem: FeasibleProblem, solver: ConicSolver = "clarabel") -> SolverResult:
    """Solve by Clarabel (interior point) or SCS (first order).

    Raises:
        SolverFailed: If there is no solution to look at.
    """
    start = time.perf_counter()
    x, links, rows, program = _build(problem)
    settings = CLARABEL_SETTINGS if solver == "clarabel" else SCS_SETTINGS
    try:
        with warnings.catch_warnings():
            # The status says the same, and the solution is checked in any case.
            warnings.filterwarnings("ignore", message="Solution may be inaccurate")
            program.solve(solver=solver.upper(), **settings)
    except cp.SolverError as error:
        raise SolverFailed("no solution", (f"{solver}: {error}",)) from error
    if x.value is None:
        raise SolverFailed("no solution", (f"{solver}: {program.status}",))
    prices = np.atleast_1d(np.asarray(rows[0].dual_value)) if rows else np.zeros(0)
    return SolverResult(
        x=np.asarray(x.value, dtype=float),
        multipliers=Multipliers(np.array([link.dual_value for link in links]), prices),
        solver=solver,
        status=str(program.status),
        iterations=int(program.solver_stats.num_iters or 0),
        seconds=time.perf_counter() - start,
    )


def _build(
    problem: FeasibleProblem,
) -> tuple[cp.Variable, list[cp.Constraint], list[cp.Constraint], cp.Problem]:
    coordinates, regularisation = problem.coordinates, problem.regularisation
    x = cp.Variable(coordinates.size)
    spread = BASIS.reshape(ENTRIES, 16).T
    matrices = [
        cp.reshape(spread @ x[ENTRIES * i : ENTRIES * i + ENTRIES], (4, 4), order="C")
        for i in range(coordinates.links)
    ]
    effects = x[ENTRIES * coordinates.links :]
    objective = cp.sum_squares(problem.factor @ x - problem.target)
    if effects.size:
        objective += problem.tie_break[-1] / 2 * cp.sum_squares(effects)
    if regularisation.kind == "entropic":
        traces = np.tile(IDENTITY, coordinates.links) @ x[: ENTRIES * coordinates.links]
        distance = traces - cp.sum([cp.log_det(matrix) for matrix in matrices])
    else:
        root = quadratic_root(coordinates)
        distance = cp.sum_squares(root @ (x - coordinates.start)) / 2
    links: list[cp.Constraint] = [matrix >> problem.margin * np.eye(4) for matrix in matrices]
    rows = [problem.inequality.matrix @ x >= problem.inequality.bound]
    equal = [problem.equality.matrix @ x == problem.equality.bound]
    rows, equal = rows[: len(problem.inequality)], equal[: len(problem.equality)]
    minimise = cp.Minimize(objective + regularisation.weight * distance)
    return x, links, rows, cp.Problem(minimise, [*links, *rows, *equal])
