"""A search that first goes on from a motion at hand, then as it would without."""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.optimisers.local_solution import LocalSettings, solve_locally
from oed.design.optimisers.registry import Optimiser
from oed.design.optimisers.result import Budget, EvaluationLog, OptimiserResult
from oed.design.problem import DesignProblem


def from_motion(optimise: Optimiser, start: Float[ndarray, " size"]) -> Optimiser:
    """An optimiser whose answer is no worse than a motion, brought within the limits.

    At most half of the budget goes to a local solution from there.

    Args:
        optimise: What searches with the rest.
        start: The motion.
    """

    def search(problem: DesignProblem, budget: Budget, rng: np.random.Generator) -> OptimiserResult:
        whole = EvaluationLog(budget)
        log = EvaluationLog(whole.half())
        point = problem.repair(start)
        log.evaluate(problem.cost, point)
        if not log.is_spent:
            solution, _ = solve_locally(problem, point, log, LocalSettings(), is_warm=True)
            log.evaluate(problem.cost, solution)
        near = log.result("gone on from a motion at hand")
        whole.evaluations = near.evaluations
        if whole.is_spent:
            return near
        seconds = budget.cpu_seconds
        rest = Budget(
            None if budget.evaluations is None else int(whole.left),
            None if seconds is None else seconds - whole.cpu_s,
        )
        found = optimise(problem, rest, rng)
        best = near if near.cost <= found.cost else found
        return dataclasses.replace(
            best,
            evaluations=near.evaluations + found.evaluations,
            cpu_s=whole.cpu_s,
            status=f"{near.status}; {found.status}",
        )

    return search
