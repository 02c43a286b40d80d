"""SciPy's SLSQP from many starts: a general gradient solver as a control.

Kraft 1988, "A software package for sequential quadratic programming". It sees the limits at a
grid of instants; what it visits is repaired into the limits, evaluated exactly and kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.optimize
from jaxtyping import Float
from numpy import ndarray

from oed.design.constraints import LimitConstraints
from oed.design.optimisers.result import Budget, EvaluationLog, OptimiserResult
from oed.design.problem import DesignProblem


@dataclass(frozen=True)
class SlsqpSettings:
    """Settings of the solver.

    Attributes:
        instants: Equally spaced instants at which it sees the limits.
        exponents: Schatten exponents of the smooth stand-in for J_k and E, solved in turn.
        iterations: Per exponent.
        tolerance: On the change of the cost [decades].
    """

    instants: int = 40
    exponents: tuple[float, ...] = (6.0, 40.0)
    iterations: int = 80
    tolerance: float = 1e-6


class _BudgetSpent(Exception):
    """Leaves the solver's loop, which has no other door."""


def optimise(
    problem: DesignProblem,
    budget: Budget,
    rng: np.random.Generator,
    settings: SlsqpSettings | None = None,
) -> OptimiserResult:
    """Minimise by SLSQP from random starts until the budget is spent.

    An evaluation of the cost with its gradient counts as one evaluation, and so does the exact
    evaluation of each repaired iterate: the budget of CPU seconds shows what either costs.

    Args:
        problem: To be minimised.
        budget: When to stop.
        rng: Source of the starts.
        settings: Of the solver.
    """
    settings = settings or SlsqpSettings()
    log = EvaluationLog(budget)
    starts = 0
    while not log.is_spent or log.best_z is None:
        start = problem.random_start(rng)
        log.evaluate(problem.cost, start)
        starts += 1
        try:
            for exponent in _exponents(problem, settings):
                start = _descend(problem, log, start, exponent, settings)
        except _BudgetSpent:
            break
    if log.best_z is None:
        log.offer(problem.random_start(rng), np.finfo(float).max)
    return log.result(f"budget spent in start {starts}")


def _exponents(problem: DesignProblem, settings: SlsqpSettings) -> tuple[float, ...]:
    is_smooth = problem.criterion in ("J_d", "A")
    return (np.inf,) if is_smooth else settings.exponents


def _descend(
    problem: DesignProblem,
    log: EvaluationLog,
    start: Float[ndarray, " size"],
    exponent: float,
    settings: SlsqpSettings,
) -> Float[ndarray, " size"]:
    """One call of the solver, in coordinates of the unit box."""
    lower, upper = problem.trajectory.bounds.T
    span = upper - lower

    def cost(x: ndarray) -> tuple[float, ndarray]:
        if log.is_spent:
            raise _BudgetSpent
        value, gradient = problem.cost_and_gradient(lower + x * span, exponent=exponent)
        log.count()
        # SLSQP compares values: a singular point must be worse than any other, not infinite.
        return (value if np.isfinite(value) else 1e6), gradient * span

    def keep(x: ndarray) -> None:
        if not log.is_spent:
            log.evaluate(problem.cost, problem.quick_repair(lower + x * span))

    instants = problem.trajectory.limit_instants(settings.instants)
    limits = LimitConstraints(problem.trajectory, problem.limits, instants)
    result = scipy.optimize.minimize(
        cost,
        (start - lower) / span,
        jac=True,
        method="SLSQP",
        bounds=[(0.0, 1.0)] * len(span),
        constraints={
            "type": "ineq",
            "fun": lambda x: limits.room(lower + x * span),
            "jac": lambda x: limits.room_jacobian(lower + x * span) * span,
        },
        callback=keep,
        options={"maxiter": settings.iterations, "ftol": settings.tolerance},
    )
    end = result.x if np.isfinite(result.x).all() else (start - lower) / span
    keep(end)
    return problem.quick_repair(lower + np.clip(end, 0.0, 1.0) * span)
