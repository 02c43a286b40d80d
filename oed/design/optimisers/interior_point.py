"""Interior-point design: IPOPT from many starts, a homotopy to the exact criterion, exchange.

Local solutions from random starts and from hops around the best; see `local_solution`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.counted import counted
from oed.design.optimisers.local_solution import LocalSettings, solve_locally
from oed.design.optimisers.polish import polish
from oed.design.optimisers.result import Budget, EvaluationLog, OptimiserResult
from oed.design.optimisers.starts import structured_start
from oed.design.problem import DesignProblem


@dataclass(frozen=True)
class InteriorPointSettings:
    """How the interior-point optimiser works.

    Attributes:
        local: How each local solution is found.
        hop_sizes: Least and greatest standard deviation of a hop, relative to the box.
        hop_variables: Share of the variables that a hop moves.
        hop_share: Probability that a start after the first ones is a hop.
        first_starts: Starts before hops begin.
        polish_evaluations: Spent on the exact criterion after each promising solution.
        promising: A solution is polished if its cost is at most this much above the best
            [decades].
    """

    local: LocalSettings = field(default_factory=LocalSettings)
    hop_sizes: tuple[float, float] = (0.01, 0.3)
    hop_variables: float = 0.3
    hop_share: float = 0.7
    first_starts: int = 4
    polish_evaluations: int = 200
    promising: float = 0.01


def optimise(
    problem: DesignProblem,
    budget: Budget,
    rng: np.random.Generator,
    settings: InteriorPointSettings | None = None,
) -> OptimiserResult:
    """Minimise the problem's criterion by IPOPT from many starts.

    Never fails: the first start is feasible by repair, and only better feasible points follow.

    Args:
        problem: What to design.
        budget: When to stop; a local solution under way is cut short.
        rng: Of starts and hops.
        settings: How to work; the defaults if None.
    """
    settings = settings or InteriorPointSettings()
    log = EvaluationLog(budget)
    starts = hops = 0
    while not log.is_spent:
        may_hop = starts >= settings.first_starts and rng.random() < settings.hop_share
        best = log.best_z if may_hop else None
        is_hop = best is not None
        if best is not None:
            start = _hop(problem, best, rng, settings)
        elif starts == 0:
            start = structured_start(problem, rng)
        else:
            start = problem.random_start(rng)
        log.evaluate(problem.cost, start)
        starts, hops = starts + 1, hops + is_hop
        if log.is_spent:
            break
        solution, _ = solve_locally(problem, start, log, settings.local, is_warm=is_hop)
        before = log.best_cost
        value = log.evaluate(problem.cost, solution)
        if value <= before + settings.promising and not log.is_spent:
            polish(problem, solution, value, log, rng, evaluations=settings.polish_evaluations)
    return log.result(f"{counted(starts, 'local solution')}, {counted(hops, 'hop')}")


def _hop(
    problem: DesignProblem,
    best: Float[ndarray, " size"],
    rng: np.random.Generator,
    settings: InteriorPointSettings,
) -> Float[ndarray, " size"]:
    """The best point with some variables moved, some hops small and some large."""
    width = np.diff(problem.trajectory.bounds, axis=1)[:, 0]
    size = np.exp(rng.uniform(*np.log(settings.hop_sizes)))
    moves = rng.random(problem.size) < settings.hop_variables
    return problem.repair(best + size * width * moves * rng.standard_normal(problem.size))
