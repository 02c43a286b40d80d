"""A short descent on the exact criterion, which neither smooth sign nor Schatten norm sees."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.optimisers.result import EvaluationLog
from oed.design.problem import DesignProblem

FIRST_STEP = 1e-3  # of the box: what is polished is near its optimum; assumed
LAST_STEP = 1e-7  # likewise: what a smaller one gains is rounding
# Growth after success and shrinkage after failure balance at one success in five (Rechenberg).
GROWTH = 1.5
SHRINKAGE = GROWTH**-0.25


def polish(
    problem: DesignProblem,
    z: Float[ndarray, " size"],
    value: float,
    log: EvaluationLog,
    rng: np.random.Generator,
    *,
    evaluations: int,
) -> Float[ndarray, " size"]:
    """Improve a feasible point by a (1+1) evolution strategy on repaired points.

    Every trial is repaired before it is judged, so that the exact criterion is compared where
    it will be reported; the strategy's shape follows its own successes (rank one).

    Args:
        problem: What is minimised, exactly.
        z: A feasible point.
        value: The exact cost there.
        log: Counts, and keeps the best.
        rng: Of the steps.
        evaluations: Most to spend.
    """
    width = np.diff(problem.trajectory.bounds, axis=1)[:, 0]
    best, best_value, step = np.array(z), value, FIRST_STEP
    path = np.zeros(problem.size)
    for _ in range(evaluations):
        if log.is_spent or step < LAST_STEP:
            break
        move = rng.standard_normal(problem.size) + path * rng.standard_normal()
        trial = problem.repair(best + step * width * move)
        trial_value = log.evaluate(problem.cost, trial)
        if trial_value < best_value:
            path = 0.7 * path + 0.3 * move
            best, best_value = trial, trial_value
            step *= GROWTH
        else:
            step *= SHRINKAGE
    return best
