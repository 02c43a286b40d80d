"""Interior-point design: IPOPT from many starts, a homotopy to the exact criterion, exchange.

Each local solution runs a sequence of smooth problems: the velocity sign turns sharper and, for
J_k and E, the Schatten exponent rises. Limits stand at a few instants; where the proven extrema
of the solution lie beyond them, those instants join and the last problem is solved again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.constraints import LimitConstraints
from oed.design.limits import KINEMATIC
from oed.design.optimisers.nonlinear_program import solve_program
from oed.design.optimisers.polish import polish
from oed.design.optimisers.result import Budget, EvaluationLog, OptimiserResult
from oed.design.optimisers.starts import structured_start
from oed.design.problem import DesignProblem

UNBOUNDED = 1_000_000  # iterations, where a budget does not bound them


@dataclass(frozen=True)
class Stage:
    """One smooth stand-in for the criterion.

    Attributes:
        sign_width: Of the smooth velocity sign [rad/s].
        exponent: Of the Schatten norms, for J_k and E.
    """

    sign_width: float
    exponent: float


@dataclass(frozen=True)
class InteriorPointSettings:
    """How the interior-point optimiser works.

    Attributes:
        stages: Smooth problems solved one after the other, each from the last one's solution.
        warm_stages: How many of the last of them a hop goes through.
        iterations: Most of IPOPT in one stage.
        constraint_instants: Equally spaced instants at which limits first stand.
        exchanges: Most rounds of adding violated extrema.
        hop_sizes: Least and greatest standard deviation of a hop, relative to the box.
        hop_variables: Share of the variables that a hop moves.
        hop_share: Probability that a start after the first ones is a hop.
        first_starts: Starts before hops begin.
        polish_evaluations: Spent on the exact criterion after each promising solution.
        promising: A solution is polished if its cost is at most this much above the best
            [decades].
    """

    stages: tuple[Stage, ...] = (Stage(0.3, 4.0), Stage(0.1, 16.0), Stage(0.03, 64.0))
    warm_stages: int = 2
    iterations: int = 150
    constraint_instants: int = 40
    exchanges: int = 3
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
        is_hop = starts >= settings.first_starts and rng.random() < settings.hop_share
        start = _hop(problem, log.best_z, rng, settings) if is_hop else None
        if start is None:
            start = structured_start(problem, rng) if starts == 0 else problem.random_start(rng)
        log.evaluate(problem.cost, start)
        solution, _ = solve_locally(problem, start, log, settings, is_warm=is_hop)
        starts, hops = starts + 1, hops + is_hop
        before = log.best_cost
        value = log.evaluate(problem.cost, solution)
        if value <= before + settings.promising and not log.is_spent:
            polish(problem, solution, value, log, rng, evaluations=settings.polish_evaluations)
    return log.result(f"{starts} local solutions, {hops} of them from hops; budget used up")


def solve_locally(
    problem: DesignProblem,
    start: Float[ndarray, " size"],
    log: EvaluationLog,
    settings: InteriorPointSettings,
    *,
    is_warm: bool = False,
) -> tuple[Float[ndarray, " size"], bool]:
    """One local solution: stages, then exchange, then repair.

    Args:
        problem: What to design.
        start: A feasible point.
        log: Counts, and says when to stop.
        settings: How to work.
        is_warm: Whether the start is near a solution, so that the last stages will do.

    Returns:
        A feasible point, and whether IPOPT converged in the last round.
    """
    instants = np.linspace(0.0, problem.trajectory.horizon, settings.constraint_instants)
    z, is_converged = start, False
    stages = settings.stages[-settings.warm_stages :] if is_warm else settings.stages
    for number, stage in enumerate(stages):
        if log.is_spent:
            break
        smooth = _Smooth(problem, stage, instants, settings.iterations)
        z, is_converged = smooth.solve(z, log, is_warm=is_warm or number > 0)
    for _ in range(settings.exchanges):
        added = _violated(problem, z)
        if log.is_spent or not len(added):
            break
        instants = np.union1d(instants, added)
        smooth = _Smooth(problem, stages[-1], instants, settings.iterations)
        z, is_converged = smooth.solve(z, log, is_warm=True)
    return problem.repair(z), is_converged


@dataclass(frozen=True)
class _Smooth:
    """The smooth problem of one stage, its limits at some instants."""

    problem: DesignProblem
    stage: Stage
    instants: Float[ndarray, " samples"]
    iterations: int

    def cost_and_gradient(
        self, z: Float[ndarray, " size"]
    ) -> tuple[float, Float[ndarray, " size"]]:
        return self.problem.cost_and_gradient(
            z, sign_width=self.stage.sign_width, exponent=self.stage.exponent
        )

    def solve(
        self, z: Float[ndarray, " size"], log: EvaluationLog, *, is_warm: bool
    ) -> tuple[Float[ndarray, " size"], bool]:
        iterations, seconds = _left(log)
        solution = solve_program(
            self.cost_and_gradient,
            LimitConstraints(self.problem.trajectory, self.problem.limits, self.instants),
            z,
            iterations=min(self.iterations, iterations),
            cpu_seconds=seconds,
            is_warm=is_warm,
        )
        log.count(solution.evaluations)
        return solution.z, solution.is_converged


def _left(log: EvaluationLog) -> tuple[int, float]:
    """Iterations and CPU seconds that the budget leaves to one run of IPOPT."""
    budget = log.budget
    seconds = budget.longest - log.cpu_s
    if budget.needs_both:  # either alone may be overspent
        return UNBOUNDED, seconds
    if budget.cpu_seconds is not None:
        seconds = min(seconds, budget.cpu_seconds - log.cpu_s)
    if budget.evaluations is None:
        return UNBOUNDED, seconds
    return max(1, budget.evaluations - log.evaluations), seconds


def _violated(problem: DesignProblem, z: Float[ndarray, " size"]) -> Float[ndarray, " samples"]:
    """Instants of local extrema beyond a limit by more than a part in a thousand."""
    t = np.linspace(0.0, problem.trajectory.horizon, 1001)
    found = []
    for order, kind in enumerate(KINEMATIC):
        limit = getattr(problem.limits, kind)
        if not np.isfinite(limit).any():
            continue
        signal = problem.trajectory.derivative(z, t, order)
        for sign, side in ((1.0, 1), (-1.0, 0)):
            beyond = sign * (signal - limit[:, side])
            tolerance = 1e-3 * np.abs(limit[:, side])
            padded = np.pad(beyond, ((1, 1), (0, 0)), constant_values=-np.inf)
            is_peak = (beyond >= padded[:-2]) & (beyond >= padded[2:]) & (beyond > tolerance)
            found.append(t[is_peak.any(axis=1)])
    return np.unique(np.concatenate(found)) if found else np.zeros(0)


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
