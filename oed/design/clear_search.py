"""The best motion there is, and the best one that keeps the arm clear."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.counted import counted
from oed.design.clear_posture import clear_posture
from oed.design.clearance import ClearanceCheck
from oed.design.collision import Surroundings
from oed.design.collision_free import find_clear_motion
from oed.design.optimisers.interior_point import optimise as interior_point
from oed.design.optimisers.registry import Optimiser
from oed.design.optimisers.result import Budget, EvaluationLog, OptimiserResult
from oed.design.problem import DesignProblem


@dataclass(frozen=True)
class ClearSearch:
    """What a search found.

    Attributes:
        found: The motion that keeps clear, if there is something to keep clear of.
        free: (size,) the best motion found that need not; None if that is the same.
        is_cut_short: CPU time ended the search before it had all its evaluations.
        is_kept_on: The second search went on beyond its evaluations, as nothing was clear before.
        check: What is proven of the distances of `found`; None where nothing had to be kept.
    """

    found: OptimiserResult
    free: Float[ndarray, " size"] | None
    is_cut_short: bool
    is_kept_on: bool = False
    check: ClearanceCheck | None = None


def search_clear(
    problem: DesignProblem,
    surroundings: Surroundings | None,
    budget: Budget,
    rng: np.random.Generator,
    optimise: Optimiser = interior_point,
) -> ClearSearch:
    """Search without distances to keep, then from there with them, by an interior point.

    Half of the budget goes to the first search, the second has what is left. Where that comes to
    no clear motion with its evaluations, it makes more, until the first one that is clear.

    Args:
        problem: As for `find_clear_motion`.
        surroundings: What the motion must keep clear of; None for nothing.
        budget: In evaluations, CPU seconds or both.
        rng: Of the starts.
        optimise: Of the first search.

    Raises:
        NoUsableResult: If no motion is found that keeps clear, or no posture does.
    """
    if surroundings is None:
        found = optimise(problem, budget, rng)
        return ClearSearch(found, None, _is_cut_short(found, budget))
    log = EvaluationLog(budget)
    half = log.half()
    clear_posture(problem.limits, surroundings, rng.spawn(1)[0])  # before all work, if none is
    free = optimise(problem, half, rng)
    log.evaluations = free.evaluations
    clear = find_clear_motion(problem, free.z, surroundings, log, rng)
    found = dataclasses.replace(
        free,
        z=clear.z,
        cost=clear.cost,
        evaluations=log.evaluations,
        cpu_s=log.cpu_s,
        status=f"{free.status}; {counted(clear.rounds, 'round')} to keep clear",
    )
    before = free.z if clear.rounds else None
    is_kept_on = log.left <= 0 and log.evaluations > (budget.evaluations or 0) >= free.evaluations
    is_cut_short = log.is_late or _is_cut_short(free, half)
    return ClearSearch(found, before, is_cut_short, is_kept_on, clear.check)


def _is_cut_short(found: OptimiserResult, budget: Budget) -> bool:
    # Not by the CPU time spent: a solver may stop a moment before its limit.
    return budget.evaluations is not None and found.evaluations < budget.evaluations
