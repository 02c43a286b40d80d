"""Random search: the control that every optimiser has to beat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.optimisers.problem import Problem
from oed.design.optimisers.result import Budget, EvaluationLog, OptimiserResult


@dataclass(frozen=True)
class RandomSearchSettings:
    """Where the points come from.

    Attributes:
        draw: "start" for the problem's own sensible random motions, "box" for the uniform
            distribution on the box, repaired into the limits.
    """

    draw: Literal["start", "box"] = "start"


def optimise(
    problem: Problem,
    budget: Budget,
    rng: np.random.Generator,
    settings: RandomSearchSettings | None = None,
) -> OptimiserResult:
    """The best of independent random feasible points.

    Args:
        problem: To be minimised.
        budget: When to stop.
        rng: Source of every draw.
        settings: Where the points come from.
    """
    settings = settings or RandomSearchSettings()
    log = EvaluationLog(budget)
    while not log.is_spent or log.evaluations == 0:
        log.evaluate(problem.cost, _draw(problem, rng, settings))
    if log.best_z is None:
        log.offer(_draw(problem, rng, settings), np.finfo(float).max)
    return log.result(f"best of {log.evaluations} random points")


def _draw(
    problem: Problem, rng: np.random.Generator, settings: RandomSearchSettings
) -> Float[ndarray, " size"]:
    if settings.draw == "start":
        return problem.random_start(rng)
    lower, upper = problem.trajectory.bounds.T
    return problem.quick_repair(rng.uniform(lower, upper))
