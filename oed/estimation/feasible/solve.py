"""A solution with the accuracy that it reached, or a proof that there is none.

Each solver is tried until one passes the check of optimality. A conic solver that does not is
asked once more with the problem measured at what it found. If none passes, the most accurate
feasible point is the answer, and says how accurate it is.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.errors import OedError
from oed.estimation.feasible.barrier_solver import solve_barrier
from oed.estimation.feasible.conic_solver import SolverResult, solve_conic
from oed.estimation.feasible.coordinates import IDENTITY
from oed.estimation.feasible.interior import (
    TAKES_PART,
    Certificate,
    Interior,
    SolverFailed,
    most_interior,
)
from oed.estimation.feasible.optimality import (
    FEASIBLE_TO,
    TOLERANCE,
    Multipliers,
    Optimality,
    check_optimality,
    primal_violation,
)
from oed.estimation.feasible.problem import FeasibleProblem

SolverName = Literal["clarabel", "barrier", "scs"]
# Steps of a half from a point that misses a demand towards the most interior one.
HALVINGS = 60


class ContradictoryDemands(OedError):
    """No parameters meet all demands, whatever the data.

    Attributes:
        demands: The demands that contradict each other.
        margin: The largest margin that any parameters were found to have, relative to the
            reference bodies; below the one demanded.
        certificate: That none has a larger one.
    """

    def __init__(
        self, message: str, demands: tuple[str, ...], margin: float, certificate: Certificate
    ) -> None:
        super().__init__(message)
        self.demands = demands
        self.margin = margin
        self.certificate = certificate


@dataclass(frozen=True)
class FeasibleSolution:
    """A solution and the evidence for it.

    Attributes:
        x: (p,) unknowns.
        multipliers: Prices of the demands.
        objective: Value of the objective, recomputed.
        optimality: Of x.
        solver: That found it.
        seconds: It took.
        attempts: One line for each solver that was tried.
        tolerance: Of the optimality conditions, that was asked for.
    """

    x: Float[ndarray, " p"]
    multipliers: Multipliers
    objective: float
    optimality: Optimality
    solver: str
    seconds: float
    attempts: tuple[str, ...]
    tolerance: float = TOLERANCE

    @property
    def is_accurate(self) -> bool:
        """Whether it is feasible, and optimal to the tolerance."""
        return self.optimality.holds(self.tolerance)

    @property
    def accuracy(self) -> str:
        """What was reached, in words."""
        reached = self.optimality.suboptimality
        feasible = (
            "all demands are met"
            if self.optimality.primal <= FEASIBLE_TO
            else f"demands are missed by {self.optimality.primal:.1e} of the reference bodies"
        )
        wanted = "" if self.is_accurate else f", where {self.tolerance:.0e} was asked for"
        return (
            f"{self.solver}: the objective is within {reached:.1e} of its optimum, relatively"
            f"{wanted}; {feasible}"
        )


def solve_problem(
    problem: FeasibleProblem,
    solvers: tuple[SolverName, ...] = ("clarabel", "barrier"),
    *,
    tolerance: float = TOLERANCE,
) -> FeasibleSolution:
    """Solve by the first solver whose solution is feasible and optimal, else the best of all.

    A solution that misses a demand by rounding is drawn towards an interior point by as
    much before it is checked.

    Args:
        problem: To solve.
        solvers: To try, in this order.
        tolerance: Of the optimality conditions.

    Raises:
        ContradictoryDemands: If nothing meets all demands.
        SolverFailed: If no solver came to any point, though something meets the demands.
    """
    attempts: list[str] = []
    found: list[tuple[FeasibleSolution, SolverResult]] = []
    for name in solvers:
        try:
            for result in _results(problem, name):
                solution = _checked(problem, _drawn_inside(problem, result.x), result, tolerance)
                attempts.append(_told(result, solution.optimality))
                found.append((solution, result))
                if solution.is_accurate:
                    return dataclasses.replace(solution, attempts=tuple(attempts))
        except SolverFailed as failure:
            attempts.append("; ".join(failure.attempts))
    if not found:
        require_interior(problem)
        raise SolverFailed("no solver found the feasible optimum", tuple(attempts))
    best, result = min(
        found, key=lambda s: (s[0].optimality.primal > FEASIBLE_TO, s[0].optimality.suboptimality)
    )
    if best.optimality.primal > FEASIBLE_TO:
        x = _towards(problem, best.x, require_interior(problem).x)
        best = _checked(problem, x, result, tolerance)
    return dataclasses.replace(best, attempts=tuple(attempts))


def _results(problem: FeasibleProblem, name: SolverName) -> Iterator[SolverResult]:
    """What a solver finds; a conic one once more, measured at its own first solution."""
    if name == "barrier":
        yield solve_barrier(problem)
        return
    first = solve_conic(problem, name)
    yield first
    inside = _drawn_inside(problem, first.x)
    if problem.link_margins(inside).min() > 0:
        yield solve_conic(problem, name, at=inside)


def _checked(
    problem: FeasibleProblem, x: Float[ndarray, " p"], result: SolverResult, tolerance: float
) -> FeasibleSolution:
    return FeasibleSolution(
        x=x,
        multipliers=result.multipliers,
        objective=problem.objective(x),
        optimality=check_optimality(problem, x, result.multipliers),
        solver=result.solver,
        seconds=result.seconds,
        attempts=(),
        tolerance=tolerance,
    )


def _told(result: SolverResult, optimality: Optimality) -> str:
    return (
        f"{result.solver}: {result.status}, {result.iterations} steps, demands missed by "
        f"{optimality.primal:.1e}, decrement {optimality.decrement:.1e}, "
        f"gap {optimality.gap:.1e}"
    )


def _towards(
    problem: FeasibleProblem, x: Float[ndarray, " p"], inner: Float[ndarray, " p"]
) -> Float[ndarray, " p"]:
    """The point nearest to x, on the line to an interior one, that meets the demands."""
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if primal_violation(problem, x + middle * (inner - x)) <= FEASIBLE_TO:
            high = middle
        else:
            low = middle
    return x + high * (inner - x)


def require_interior(problem: FeasibleProblem) -> Interior:
    """The most interior point of the demands.

    Raises:
        ContradictoryDemands: If none has the margin that is demanded, naming the demands in
            the proof.
        SolverFailed: If neither a point nor a proof was found.
    """
    inner = most_interior(problem.coordinates, problem.inequality, problem.equality)
    if inner.margin >= problem.margin:
        return inner
    proof = inner.certificate
    if proof.bound >= problem.margin:
        raise SolverFailed(
            "neither a point that meets all demands nor a proof that there is none",
            (f"largest margin {inner.margin:.1e}, bounded by {proof.bound:.1e}",),
        )
    named = [
        f"a consistent link {i + 1}" for i in np.flatnonzero(proof.links > TAKES_PART).tolist()
    ]
    named += [problem.inequality.names[k] for k in np.flatnonzero(proof.inequality > TAKES_PART)]
    largest = np.max(np.abs(proof.equality), initial=0.0)
    named += [
        problem.equality.names[k]
        for k in np.flatnonzero(np.abs(proof.equality) > TAKES_PART * largest)
    ]
    best = (
        f"at best one is missed by {-inner.margin:.2g} of its reference body"
        if inner.margin < 0
        else f"at best they leave {inner.margin:.2g} of the reference bodies, and a body that can "
        f"exist needs {problem.margin:.2g}"
    )
    raise ContradictoryDemands(
        f"these demands contradict each other: {', '.join(named)}; {best}",
        tuple(named),
        inner.margin,
        proof,
    )


def _drawn_inside(problem: FeasibleProblem, x: Float[ndarray, " p"]) -> Float[ndarray, " p"]:
    """X with eigenvalues and slacks that rounding left below their bounds put back on them."""
    links = problem.coordinates.links
    inside = np.array(x)
    short = problem.margin - problem.link_margins(x)
    # Adding s I to J^ adds s to each of its eigenvalues.
    lift = np.where(short > 0, short * (1 + 1e-9), 0.0)
    inside[: 10 * links] += (lift[:, None] * IDENTITY).reshape(-1)
    alone = (problem.inequality.matrix != 0).sum(axis=1) == 1
    for row in problem.inequality.matrix[alone & (problem.slack(x) < 0)]:
        column = int(np.flatnonzero(row)[0])
        inside[column] = max(inside[column], 0.0)
    return inside
