"""A modern evolution strategy as a control: CMA-ES of the package `cma`, with restarts.

N. Hansen, "The CMA evolution strategy: a tutorial", arXiv:1604.00772; restarts with doubled
population after Auger and Hansen 2005, "A restart CMA evolution strategy with increasing
population size".
"""

from __future__ import annotations

from dataclasses import dataclass

import cma
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.optimisers.problem import Problem
from oed.design.optimisers.result import Budget, EvaluationLog, OptimiserResult


@dataclass(frozen=True)
class EvolutionSettings:
    """Settings of the strategy; lengths are fractions of the box.

    Attributes:
        step: Initial standard deviation.
        population: Of the first run; None for the package's 4 + 3 ln(size).
        population_growth: Factor of the population at each restart.
        repair_weight: Cost per squared distance between a point and its repair. Without it
            the cost would be flat along the direction in which repair scales.
    """

    step: float = 0.2
    population: int | None = None
    population_growth: int = 2
    repair_weight: float = 0.1


def optimise(
    problem: Problem,
    budget: Budget,
    rng: np.random.Generator,
    settings: EvolutionSettings | None = None,
) -> OptimiserResult:
    """Minimise by CMA-ES on the unit box, restarted until the budget is spent.

    Args:
        problem: To be minimised; infeasible points are repaired, then evaluated.
        budget: When to stop.
        rng: Source of every draw.
        settings: Step and restarts.
    """
    settings = settings or EvolutionSettings()
    log = EvaluationLog(budget)
    default = 4 + int(3 * np.log(len(problem.trajectory.bounds)))
    population = settings.population or default
    runs = 0
    while not log.is_spent or log.evaluations == 0:
        _run(problem, log, rng, settings, population)
        population *= settings.population_growth
        runs += 1
    if log.best_z is None:
        log.offer(problem.random_start(rng), np.finfo(float).max)
    return log.result(f"budget spent in run {runs}")


def _run(
    problem: Problem,
    log: EvaluationLog,
    rng: np.random.Generator,
    settings: EvolutionSettings,
    population: int,
) -> None:
    """One run, until the strategy stops by itself or the budget is spent."""
    lower, upper = problem.trajectory.bounds.T
    start = problem.random_start(rng)
    log.evaluate(problem.cost, start)
    strategy = cma.CMAEvolutionStrategy(
        (start - lower) / (upper - lower),
        settings.step,
        {
            "bounds": [0.0, 1.0],
            "popsize": population,
            "randn": lambda *shape: rng.standard_normal(shape),
            "seed": np.nan,  # leave numpy's global generator alone
            "verbose": -9,
            "verb_log": 0,
            "CMA_diagonal": False,
        },
    )
    while not strategy.stop():
        points = strategy.ask()
        costs: list[float] = []
        for point in points:
            if log.is_spent:
                return
            costs.append(_penalised(problem, log, lower + point * (upper - lower), settings))
        strategy.tell(points, costs)


def _penalised(
    problem: Problem,
    log: EvaluationLog,
    z: Float[ndarray, " size"],
    settings: EvolutionSettings,
) -> float:
    """Cost of the repaired point, plus a little for the distance to it."""
    repaired = problem.quick_repair(z)
    cost = log.evaluate(problem.cost, repaired)
    # A finite stand-in: the strategy ranks points, and infinity minus infinity has no rank.
    cost = cost if np.isfinite(cost) else np.finfo(np.float32).max
    span = np.diff(problem.trajectory.bounds, axis=1)[:, 0]
    return float(cost + settings.repair_weight * (((z - repaired) / span) ** 2).sum())
