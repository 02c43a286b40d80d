"""The problem as a conic program, for solvers of those."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import block_diag

from oed.estimation.feasible.cone_program import (
    ConeProgram,
    ConeRows,
    ConicSolver,
    solve_cones,
)
from oed.estimation.feasible.coordinates import BASIS, ENTRIES, IDENTITY, adjoint
from oed.estimation.feasible.optimality import Multipliers
from oed.estimation.feasible.problem import FeasibleProblem
from oed.estimation.feasible.regularisation import quadratic_root
from oed.estimation.triangular import triangularise

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
    to_unknowns = _to_unknowns(problem, roots)
    settings = CLARABEL_SETTINGS if solver == "clarabel" else SCS_SETTINGS
    found = solve_cones(_program(problem, roots, to_unknowns, size), solver, settings)
    turned = np.linalg.inv(roots)
    # The cones of the demands on links come before those of the logarithms.
    links = problem.coordinates.links
    duals = np.tensordot(found.semidefinite[: ENTRIES * links].reshape(-1, ENTRIES), BASIS, axes=1)
    return SolverResult(
        x=to_unknowns @ found.x[: problem.coordinates.size],
        multipliers=Multipliers(
            size * turned.transpose(0, 2, 1) @ duals @ turned,
            size * found.nonnegative,
        ),
        solver=solver,
        status=found.status,
        iterations=found.iterations,
        seconds=time.perf_counter() - start,
    )


def _to_unknowns(
    problem: FeasibleProblem, roots: Float[ndarray, "links 4 4"]
) -> Float[ndarray, "p p"]:
    """X of y: links measured by their roots, effects as they are."""
    blocks = [
        np.einsum("aij,kij->ak", BASIS, root @ BASIS @ root.T).reshape(ENTRIES, ENTRIES)
        for root in roots
    ]
    effects = problem.coordinates.size - ENTRIES * len(roots)
    return np.asarray(block_diag(*blocks, np.eye(effects)))


def _program(
    problem: FeasibleProblem,
    roots: Float[ndarray, "links 4 4"],
    to_unknowns: Float[ndarray, "p p"],
    size: float,
) -> ConeProgram:
    """The program in y, the residuals e of the squares, and the logarithms' own variables.

    e is a variable because e^T e has the squares' condition where y^T P y would square it.
    """
    p, links = problem.coordinates.size, len(roots)
    inertial = ENTRIES * links
    pull = problem.regularisation
    logarithms = 4 * links if pull.kind == "entropic" else 0
    count = 2 * p + (inertial + logarithms if logarithms else 0)
    linear = np.zeros(count)
    pairs, triples = ConeRows.none(count), ConeRows.none(count)
    if logarithms:
        # log det J^ is log det Y and a constant.
        weight = pull.weight / size
        linear[:inertial] = weight * np.tile(IDENTITY, links) @ to_unknowns[:inertial, :inertial]
        linear[-logarithms:] = -weight
        pairs, triples = _logarithms(links, p)
    triangle = triangularise(_squares(problem, to_unknowns)) / np.sqrt(size)
    residuals = np.hstack([-triangle[:p, :p], np.eye(p), np.zeros((p, count - 2 * p))])
    equal, at_least = (
        ConeRows(-_of_y(rows.matrix @ to_unknowns, count), -rows.bound)
        for rows in (problem.equality, problem.inequality)
    )
    least = [problem.margin * np.linalg.inv(root.T @ root) for root in roots]
    margins = ConeRows(-np.eye(inertial, count), -adjoint(np.array(least)))
    return ConeProgram(
        quadratic=np.repeat([0.0, 2.0, 0.0], [p, p, count - 2 * p]),
        linear=linear,
        zero=_join(ConeRows(residuals, -triangle[:p, p]), equal),
        nonnegative=at_least,
        semidefinite=_join(margins, pairs),
        orders=(4,) * links + (8,) * (logarithms // 4),
        exponential=triples,
    )


def _squares(
    problem: FeasibleProblem, to_unknowns: Float[ndarray, "p p"]
) -> Float[ndarray, "rows width"]:
    """[A b] of all terms |A y - b|^2 of the objective: data, ties of effects, a quadratic pull."""
    coordinates, pull = problem.coordinates, problem.regularisation
    effects = np.diag(np.sqrt(problem.tie_break / 2))[ENTRIES * coordinates.links :]
    parts = [(problem.factor, problem.target), (effects, np.zeros(len(effects)))]
    if pull.kind == "quadratic":
        root = np.sqrt(pull.weight / 2) * quadratic_root(coordinates)
        parts.append((root, root @ coordinates.start))
    return np.vstack([np.column_stack([A @ to_unknowns, b]) for A, b in parts])


def _logarithms(links: int, p: int) -> tuple[ConeRows, ConeRows]:
    """Cones that hold the log-determinant of each Y up to the sum of four variables.

    With U upper triangular and D its diagonal, [D U; U^T Y] is positive semidefinite if and only
    if Y - U^T D^-1 U is, and then det Y is at least det D (Ben-Tal and Nemirovski 2001, Lectures on
    Modern Convex Optimization, section 4.2): the logarithms of D are exponential cones. The
    variables, after y and e, are the U of all links and then their logarithms.
    """
    upper, whole = (list(zip(*np.triu_indices(size), strict=True)) for size in (4, 8))
    of_y, of_u = np.zeros((2, len(whole), ENTRIES))
    for k, (i, j) in enumerate(upper):
        of_y[whole.index((4 + i, 4 + j)), k] = 1.0
        of_u[whole.index((i, 4 + j)), k] = np.sqrt(2)
        if i == j:
            of_u[whole.index((i, i)), k] = 1.0
    each, inertial = np.eye(links), ENTRIES * links
    pairs = np.zeros((len(whole) * links, 2 * p + inertial + 4 * links))
    pairs[:, :inertial] = np.kron(each, of_y)
    pairs[:, 2 * p : 2 * p + inertial] = np.kron(each, of_u)
    # Triples (logarithm, 1, entry of D).
    triples = np.zeros((4 * links, 3, pairs.shape[1]))
    triples[:, 0, 2 * p + inertial :] = np.eye(4 * links)
    triples[:, 2, 2 * p : 2 * p + inertial] = np.kron(
        each, [[float(entry == (i, i)) for entry in upper] for i in range(4)]
    )
    return (
        ConeRows(-pairs, np.zeros(len(pairs))),
        ConeRows(-triples.reshape(12 * links, -1), np.tile([0.0, 1.0, 0.0], 4 * links)),
    )


def _of_y(matrix: Float[ndarray, "r p"], count: int) -> Float[ndarray, "r v"]:
    return np.pad(matrix, ((0, 0), (0, count - matrix.shape[1])))


def _join(first: ConeRows, second: ConeRows) -> ConeRows:
    return ConeRows(
        np.vstack([first.matrix, second.matrix]), np.concatenate([first.offset, second.offset])
    )
