"""Basin hopping: local solutions from neighbours of the best one, in chains that start afresh.

D. Wales and J. Doye 1997, "Global optimization by basin-hopping", at zero temperature: a hop is
kept if it is better. A chain begins at the best of a few starts and ends when many hops in a row
have failed. Made for sums of sines with free frequencies, where local optima are many.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.counted import counted
from oed.design.optimisers.local_solution import LocalSettings, solve_locally
from oed.design.optimisers.moves import neighbour
from oed.design.optimisers.result import Budget, EvaluationLog, OptimiserResult
from oed.design.optimisers.sequential_quadratic import solve_quadratic
from oed.design.optimisers.starts import mixed_start
from oed.design.problem import DesignProblem


@dataclass(frozen=True)
class HoppingSettings:
    """How the strategy works.

    Attributes:
        local: How each local solution is found.
        starts: Starts of a chain, solved to the first stage; the best of them begins it.
        patience: Failed hops in a row that end a chain.
        improvement: Least gain of a successful hop [decades].
    """

    local: LocalSettings = field(
        default_factory=lambda: LocalSettings(
            iterations=80, constraint_instants=48, solver=solve_quadratic
        )
    )
    starts: int = 12
    patience: int = 40
    improvement: float = 1e-4


def optimise(
    problem: DesignProblem,
    budget: Budget,
    rng: np.random.Generator,
    settings: HoppingSettings | None = None,
) -> OptimiserResult:
    """Minimise the problem's criterion by chains of hops.

    Args:
        problem: What to design.
        budget: When to stop; a local solution under way is cut short.
        rng: Of starts and hops.
        settings: How to work; the defaults if None.
    """
    settings = settings or HoppingSettings()
    log = EvaluationLog(budget)
    chains = solutions = hops = 0
    while not log.is_spent or log.best_z is None:
        chains += 1
        solved, hopped = _chain(problem, log, rng, settings)
        solutions, hops = solutions + solved, hops + hopped
    made = f"{counted(chains, 'chain')}, {counted(solutions, 'local solution')}"
    return log.result(f"{made}, {counted(hops, 'hop')}")


def _chain(
    problem: DesignProblem,
    log: EvaluationLog,
    rng: np.random.Generator,
    settings: HoppingSettings,
) -> tuple[int, int]:
    """One chain, until it is stuck or the budget is spent; its local solutions, and the hops of them."""
    first = replace(settings.local, stages=settings.local.stages[:1], exchanges=0)
    screened = [_solve(problem, mixed_start(problem, rng), log, first, is_warm=False)]
    while len(screened) < settings.starts and not log.is_spent:
        screened.append(_solve(problem, mixed_start(problem, rng), log, first, is_warm=False))
    if log.is_spent:
        return len(screened), 0
    best, _ = min(screened, key=lambda pair: pair[1])
    best, best_cost = _solve(problem, best, log, settings.local, is_warm=True)
    failed = hops = 0
    while failed < settings.patience and not log.is_spent:
        z, cost = _solve(problem, neighbour(problem, best, rng), log, settings.local, is_warm=True)
        hops += 1
        failed = 0 if cost < best_cost - settings.improvement else failed + 1
        if cost < best_cost:
            best, best_cost = z, cost
    return len(screened) + 1 + hops, hops


def _solve(
    problem: DesignProblem,
    start: Float[ndarray, " size"],
    log: EvaluationLog,
    settings: LocalSettings,
    *,
    is_warm: bool,
) -> tuple[Float[ndarray, " size"], float]:
    """A local solution and its exact cost; the start itself once the budget is spent."""
    if log.is_spent:
        return start, log.evaluate(problem.cost, start) if log.best_z is None else np.inf
    value = log.evaluate(problem.cost, start)
    if log.is_spent:
        return start, value
    z, _ = solve_locally(problem, start, log, settings, is_warm=is_warm)
    return z, log.evaluate(problem.cost, z)
