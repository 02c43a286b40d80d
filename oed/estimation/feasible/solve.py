"""A solution that has passed its own check, or an error: never the one for the other."""

from __future__ import annotations

from collections.abc import Callable
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
    Interior,
    SolverFailed,
    most_interior,
)
from oed.estimation.feasible.optimality import (
    TOLERANCE,
    Multipliers,
    Optimality,
    check_optimality,
)
from oed.estimation.feasible.problem import FeasibleProblem

SolverName = Literal["clarabel", "barrier", "scs"]
_SOLVERS: dict[str, Callable[[FeasibleProblem], SolverResult]] = {
    "clarabel": lambda problem: solve_conic(problem, "clarabel"),
    "barrier": solve_barrier,
    "scs": lambda problem: solve_conic(problem, "scs"),
}


class ContradictoryDemands(OedError):
    """No parameters meet all demands, whatever the data.

    Attributes:
        demands: The demands that contradict each other.
        margin: The least violation that any parameters have, relative to the reference
            bodies; negative.
    """

    def __init__(self, message: str, demands: tuple[str, ...], margin: float) -> None:
        super().__init__(message)
        self.demands = demands
        self.margin = margin


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
    """

    x: Float[ndarray, " p"]
    multipliers: Multipliers
    objective: float
    optimality: Optimality
    solver: str
    seconds: float
    attempts: tuple[str, ...]


def solve_problem(
    problem: FeasibleProblem,
    solvers: tuple[SolverName, ...] = ("clarabel", "barrier"),
    *,
    tolerance: float = TOLERANCE,
) -> FeasibleSolution:
    """Solve by the first solver whose solution is feasible and optimal.

    A solution that misses a demand by rounding is drawn towards an interior point by as
    much before it is checked.

    Args:
        problem: To solve.
        solvers: To try, in this order.
        tolerance: Of the optimality conditions.

    Raises:
        ContradictoryDemands: If nothing meets all demands.
        SolverFailed: If no solver's solution passes, though something meets the demands.
    """
    attempts: list[str] = []
    for name in solvers:
        try:
            result = _SOLVERS[name](problem)
        except SolverFailed as failure:
            attempts.append("; ".join(failure.attempts))
            continue
        x = _drawn_inside(problem, result.x)
        optimality = check_optimality(problem, x, result.multipliers)
        attempts.append(
            f"{name}: {result.status}, {result.iterations} steps, demands missed by "
            f"{optimality.primal:.1e}, decrement {optimality.decrement:.1e}, "
            f"gap {optimality.gap:.1e}"
        )
        if optimality.holds(tolerance):
            return FeasibleSolution(
                x=x,
                multipliers=result.multipliers,
                objective=problem.objective(x),
                optimality=optimality,
                solver=name,
                seconds=result.seconds,
                attempts=tuple(attempts),
            )
    require_interior(problem)
    raise SolverFailed("no solver found the feasible optimum", tuple(attempts))


def require_interior(problem: FeasibleProblem) -> Interior:
    """The most interior point of the demands.

    Raises:
        ContradictoryDemands: If there is none, naming the demands in the proof.
    """
    inner = most_interior(problem.coordinates, problem.inequality, problem.equality)
    if inner.margin >= problem.margin:
        return inner
    proof = inner.certificate
    named = [
        f"a consistent link {i + 1}" for i in np.flatnonzero(proof.links > TAKES_PART).tolist()
    ]
    named += [problem.inequality.names[k] for k in np.flatnonzero(proof.inequality > TAKES_PART)]
    largest = np.max(np.abs(proof.equality), initial=0.0)
    named += [
        problem.equality.names[k]
        for k in np.flatnonzero(np.abs(proof.equality) > TAKES_PART * largest)
    ]
    raise ContradictoryDemands(
        f"these demands contradict each other: {', '.join(named)}; at best one is missed by "
        f"{-inner.margin:.2g} of its reference body",
        tuple(named),
        inner.margin,
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
