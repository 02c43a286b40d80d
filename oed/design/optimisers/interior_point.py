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


@dataclass(frozen=True)
class InteriorPointSettings:
    """How the interior-point optimiser works.

    Attributes:
        sign_widths: Of the smooth sign, one a stage [fraction of the last, see `stages`; rad/s].
        exponents: Schatten exponent of each stage, for J_k and E.
        iterations: Most of IPOPT in one stage.
        constraint_instants: Equally spaced instants at which limits first stand.
        exchanges: Most rounds of adding violated extrema.
        hop: Standard deviation of a hop from the best point, relative to the box.
        hop_share: Probability that a start after the first few is a hop.
        first_starts: Starts before hops begin.
        structured: Whether the first start is the structured one.
        polish_evaluations: Spent on the exact criterion after each promising solution.
        promising: A solution is polished if its cost is at most this much above the best
            [decades].
    """

    sign_widths: tuple[float, ...] = (0.3, 0.1, 0.03)  # [rad/s]
    exponents: tuple[float, ...] = (4.0, 16.0, 64.0)
    iterations: int = 150
    constraint_instants: int = 80
    exchanges: int = 3
    hop: float = 0.05
    hop_share: float = 0.5
    first_starts: int = 4
    structured: bool = True
    polish_evaluations: int = 300
    promising: float = 0.02

    def __post_init__(self) -> None:
        if len(self.sign_widths) != len(self.exponents):
            raise ValueError(
                f"{len(self.sign_widths)} sign widths for {len(self.exponents)} exponents"
            )


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
    starts = converged = 0
    while not log.is_spent:
        start = _start(problem, log, rng, settings, starts)
        log.evaluate(problem.cost, start)
        solution, is_converged = solve_locally(problem, start, log, settings)
        starts += 1
        converged += is_converged
        value = log.evaluate(problem.cost, solution)
        if value <= log.best_cost + settings.promising and not log.is_spent:
            polish(problem, solution, value, log, rng, settings.polish_evaluations)
    return log.result(f"{starts} starts, {converged} converged; budget used up")


def solve_locally(
    problem: DesignProblem,
    start: Float[ndarray, "size"],
    log: EvaluationLog,
    settings: InteriorPointSettings,
) -> tuple[Float[ndarray, "size"], bool]:
    """One local solution: stages, then exchange, then repair.

    Returns:
        A feasible point, and whether IPOPT converged in the last round.
    """
    instants = np.linspace(0.0, problem.trajectory.horizon, settings.constraint_instants)
    z, is_converged = start, False
    stages = list(zip(settings.sign_widths, settings.exponents, strict=True))
    if problem.criterion in ("J_d", "A"):  # already smooth in Lambda
        stages = [(width, 1.0) for width in settings.sign_widths]
    for width, exponent in stages:
        if log.is_spent:
            break
        z, is_converged = _solve(problem, z, instants, width, exponent, log, settings)
    width, exponent = stages[-1]
    for _ in range(settings.exchanges):
        added = _violated(problem, z)
        if log.is_spent or not len(added):
            break
        instants = np.union1d(instants, added)
        z, is_converged = _solve(problem, z, instants, width, exponent, log, settings)
    return problem.repair(z), is_converged


def _solve(
    problem: DesignProblem,
    z: Float[ndarray, "size"],
    instants: Float[ndarray, "samples"],
    width: float,
    exponent: float,
    log: EvaluationLog,
    settings: InteriorPointSettings,
) -> tuple[Float[ndarray, "size"], bool]:
    solution = solve_program(
        lambda point: problem.cost_and_gradient(point, sign_width=width, exponent=exponent),
        LimitConstraints(problem.trajectory, problem.limits, instants),
        z,
        iterations=settings.iterations,
        cpu_seconds=log.seconds_left,
    )
    log.count(solution.evaluations)
    return solution.z, solution.is_converged


def _violated(problem: DesignProblem, z: Float[ndarray, "size"]) -> Float[ndarray, "samples"]:
    """Instants of local extrema beyond a limit by more than a part in ten thousand."""
    t = np.linspace(0.0, problem.trajectory.horizon, 1001)
    found = []
    for order, kind in enumerate(KINEMATIC):
        limit = getattr(problem.limits, kind)
        if not np.isfinite(limit).any():
            continue
        signal = problem.trajectory.derivative(z, t, order)
        for sign, side in ((1.0, 1), (-1.0, 0)):
            beyond = sign * (signal - limit[:, side])
            tolerance = 1e-4 * np.abs(limit[:, side])
            padded = np.pad(beyond, ((1, 1), (0, 0)), constant_values=-np.inf)
            is_peak = (beyond >= padded[:-2]) & (beyond >= padded[2:]) & (beyond > tolerance)
            found.append(t[is_peak.any(axis=1)])
    return np.unique(np.concatenate(found)) if found else np.zeros(0)


def _start(
    problem: DesignProblem,
    log: EvaluationLog,
    rng: np.random.Generator,
    settings: InteriorPointSettings,
    number: int,
) -> Float[ndarray, "size"]:
    """A structured start first, then random ones, then also hops from the best."""
    if number == 0 and settings.structured:
        return structured_start(problem, rng)
    if number < settings.first_starts or rng.random() > settings.hop_share or log.best_z is None:
        return problem.random_start(rng)
    width = np.diff(problem.trajectory.bounds, axis=1)[:, 0]
    hop = settings.hop * width * rng.standard_normal(problem.size)
    return problem.repair(log.best_z + hop)
