"""One local solution: a homotopy of smooth problems to the exact criterion, then exchange.

The velocity sign turns sharper from stage to stage and, for J_k and E, the Schatten exponent
rises. Limits stand at a few instants; where extrema of the solution lie beyond them, those
instants join and the last problem is solved again. Which solver does a stage is a setting.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.constraints import LimitConstraints, TrustRegion
from oed.design.limits import KINEMATIC
from oed.design.optimisers.nonlinear_program import solve_program
from oed.design.optimisers.result import EvaluationLog
from oed.design.optimisers.smooth_program import ProgramSolver, Spent, ValueAndGradient
from oed.design.problem import DesignProblem

# Every so many evaluations of a solver, the point it is at is repaired and offered: a run that the
# budget cuts short is worth what it had come to, at a twentieth more CPU time.
OFFERED_EVERY = 20
LAST = 1  # evaluation of a budget, which no solver gets: of the exact criterion where it ends


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
class LocalSettings:
    """How a local solution is found.

    Attributes:
        stages: Smooth problems solved one after the other, each from the last one's solution.
        warm_stages: How many of the last of them a start near a solution goes through.
        iterations: Most of the solver in one stage.
        constraint_instants: Equally spaced instants at which limits first stand.
        exchanges: Most rounds of adding violated extrema.
        solver: Of one smooth problem.
    """

    stages: tuple[Stage, ...] = (Stage(0.3, 4.0), Stage(0.1, 16.0), Stage(0.03, 64.0))
    warm_stages: int = 2
    iterations: int = 150
    constraint_instants: int = 40
    exchanges: int = 3
    solver: ProgramSolver = solve_program


def solve_locally(
    problem: DesignProblem,
    start: Float[ndarray, " size"],
    log: EvaluationLog,
    settings: LocalSettings,
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
        A feasible point, and whether the solver converged in the last round.
    """
    instants = problem.trajectory.limit_instants(settings.constraint_instants)
    z, is_converged = start, False
    stages = settings.stages[-settings.warm_stages :] if is_warm else settings.stages
    for number, stage in enumerate(stages):
        if log.is_spent:
            break
        smooth = _Smooth(problem, stage, instants, settings)
        z, is_converged = smooth.solve(z, log, is_warm=is_warm or number > 0)
    for _ in range(settings.exchanges):
        added = violated(problem, z)
        if log.is_spent or not len(added):
            break
        instants = np.union1d(instants, added)
        smooth = _Smooth(problem, stages[-1], instants, settings)
        z, is_converged = smooth.solve(z, log, is_warm=True)
    return problem.repair(z), is_converged


def solve_near(
    problem: DesignProblem,
    start: Float[ndarray, " size"],
    log: EvaluationLog,
    settings: LocalSettings,
    *,
    trust: TrustRegion,
    penalty: ValueAndGradient,
    dearer: float,
    peaks: Float[ndarray, " peaks"],
    may_exceed: bool,
) -> Float[ndarray, " size"]:
    """A solution of the last smooth problem near a motion, at a price besides.

    Args:
        problem: What to design.
        start: A feasible point.
        log: Counts, and says when to stop.
        settings: How to work.
        trust: How far the motion may move.
        penalty: The price of a point [decades], and its gradient.
        dearer: Times the usual price of excess torque, which a dear penalty would outbid.
        peaks: Instants at which limits stand besides the equally spaced ones [s].
        may_exceed: Whether evaluations may exceed the budget.

    Returns:
        A point that may violate limits between the instants.
    """
    instants = problem.trajectory.limit_instants(settings.constraint_instants)
    instants = np.union1d(instants, peaks)
    smooth = _Smooth(problem, settings.stages[-1], instants, settings, trust, penalty, dearer)
    return smooth.solve(start, log, is_warm=True, may_exceed=may_exceed)[0]


@dataclass(frozen=True)
class _Smooth:
    """The smooth problem of one stage, its limits at some instants."""

    problem: DesignProblem
    stage: Stage
    instants: Float[ndarray, " samples"]
    settings: LocalSettings
    trust: TrustRegion | None = None
    penalty: ValueAndGradient | None = None
    dearer: float = 1.0

    def cost_and_gradient(
        self, z: Float[ndarray, " size"]
    ) -> tuple[float, Float[ndarray, " size"]]:
        value, slope = self.problem.cost_and_gradient(
            z, sign_width=self.stage.sign_width, exponent=self.stage.exponent, dearer=self.dearer
        )
        if self.penalty is None:
            return value, slope
        price, push = self.penalty(z)
        return value + price, slope + push

    def solve(
        self,
        z: Float[ndarray, " size"],
        log: EvaluationLog,
        *,
        is_warm: bool,
        may_exceed: bool = False,
    ) -> tuple[Float[ndarray, " size"], bool]:
        asked, seconds = itertools.count(1), log.budget.cpu_seconds

        def objective(point: Float[ndarray, " size"]) -> tuple[float, Float[ndarray, " size"]]:
            if log.left <= LAST and not may_exceed:
                raise Spent
            log.count()
            if self.penalty is None and next(asked) % OFFERED_EVERY == 0 and log.left > LAST:
                log.evaluate(self.problem.cost, self.problem.quick_repair(point))
            return self.cost_and_gradient(point)

        solution = self.settings.solver(
            objective,
            LimitConstraints(
                self.problem.trajectory,
                self.problem.limits,
                self.instants,
                trust=self.trust,
            ),
            z,
            iterations=self.settings.iterations,
            cpu_seconds=np.inf if seconds is None else seconds - log.cpu_s,
            is_warm=is_warm,
        )
        return solution.z, solution.is_converged


def violated(problem: DesignProblem, z: Float[ndarray, " size"]) -> Float[ndarray, " samples"]:
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
