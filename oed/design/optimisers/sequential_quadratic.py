"""A smooth objective under sampled limits, given to SciPy's SLSQP.

Kraft 1988, "A software package for sequential quadratic programming". For motions of about a
dozen variables a local solution takes a third of the time that IPOPT needs, whose overhead is
the factorisation of all limits and a callback for each quantity.
"""

from __future__ import annotations

import time

import numpy as np
import scipy.optimize
from jaxtyping import Float
from numpy import ndarray

from oed.design.constraints import LimitConstraints
from oed.design.optimisers.smooth_program import SINGULAR, LocalSolution, Spent, ValueAndGradient

# Evaluations between two looks at the clock of CPU time, which can take longer than one of them.
CLOCK_EVERY = 10


class _OutOfTime(Exception):
    """Leaves the solver's loop, which has no other door."""


def solve_quadratic(
    objective: ValueAndGradient,
    constraints: LimitConstraints,
    start: Float[ndarray, " size"],
    *,
    iterations: int,
    cpu_seconds: float = np.inf,
    is_warm: bool = False,  # noqa: ARG001  # SLSQP has no barrier to keep a start away from
    tolerance: float = 1e-6,
) -> LocalSolution:
    """Minimise an objective under sampled limits and the box of the class.

    Args:
        objective: Value and gradient by z.
        constraints: The limits.
        start: First point.
        iterations: Most to make.
        cpu_seconds: Most to spend [s].
        is_warm: Of no effect.
        tolerance: On the change of the objective, with variables scaled to the box.
    """
    lower, upper = constraints.trajectory.bounds.T
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    deadline = time.process_time() + cpu_seconds
    last, evaluations = np.array(start), 0

    def cost(u: ndarray) -> tuple[float, ndarray]:
        nonlocal evaluations
        evaluations += 1
        if evaluations % CLOCK_EVERY == 0 and time.process_time() >= deadline:
            raise _OutOfTime
        value, gradient = objective(middle + half * u)
        return (value if np.isfinite(value) else SINGULAR), gradient * half

    def keep(u: ndarray) -> None:
        nonlocal last
        last = middle + half * u

    limits = {
        "type": "ineq",
        "fun": lambda u: constraints.room(middle + half * u),
        "jac": lambda u: constraints.room_jacobian(middle + half * u) * half,
    }
    try:
        result = scipy.optimize.minimize(
            cost,
            np.clip((start - middle) / half, -1.0, 1.0),
            jac=True,
            method="SLSQP",
            bounds=[(-1.0, 1.0)] * len(start),
            constraints=limits if constraints.count else (),
            callback=keep,
            options={"maxiter": iterations, "ftol": tolerance},
        )
    except Spent:
        return LocalSolution(last, evaluations, False, "out of evaluations")
    except _OutOfTime:
        return LocalSolution(last, evaluations, False, "out of time")
    point = np.clip(middle + half * result.x, lower, upper)
    if not np.isfinite(point).all():
        point = last
    return LocalSolution(point, evaluations, bool(result.success), str(result.message))
