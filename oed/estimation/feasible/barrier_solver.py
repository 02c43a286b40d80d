"""The problem by Newton steps on a sequence of barriers, sharing nothing with conic solvers.

Boyd and Vandenberghe, Convex Optimization (2004), chapter 11: minimise the objective plus mu
times the logarithmic barrier of the demands, for mu falling to rounding. The log-det pull is
kept as it is, smooth and exact, where a conic solver needs further cones for it.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import cho_factor, cho_solve, null_space

from oed.estimation.feasible.conic_solver import SolverResult
from oed.estimation.feasible.coordinates import ENTRIES, adjoint
from oed.estimation.feasible.interior import SolverFailed, most_interior
from oed.estimation.feasible.optimality import Multipliers
from oed.estimation.feasible.problem import FeasibleProblem
from oed.estimation.feasible.regularisation import log_det_hessians

FIRST_BARRIER = 1.0
SHRINK = 0.1
RELATIVE_GAP = 1e-9
DECREMENT = 1e-9  # of the barrier: a centring this exact is far inside quadratic convergence
ROUNDING = 1e-14  # of the objective: no line search can see a smaller decrease
NEWTON_STEPS = 60
JITTER = 1e-14  # on a unit diagonal: keeps a factor of what is definite but for rounding
SUFFICIENT = 0.1  # Armijo's share of the predicted decrease
LEAST_STEP = 1e-12


def solve_barrier(
    problem: FeasibleProblem, start: Float[ndarray, " p"] | None = None
) -> SolverResult:
    """Solve by path-following Newton's method.

    Args:
        problem: To solve.
        start: A strictly feasible point; the reference, or the most interior point, if None.

    Raises:
        SolverFailed: If a strictly feasible start or a Newton step cannot be found.
    """
    clock = time.perf_counter()
    x = _start(problem) if start is None else start
    directions = null_space(problem.equality.matrix) if len(problem.equality) else None
    demands = 4 * problem.coordinates.links + len(problem.inequality)
    path = _Path(problem, directions)
    mu, steps = FIRST_BARRIER * problem.size(x) / demands, 0
    while True:
        x, taken = path.centre(x, mu)
        steps += taken
        if mu * demands <= RELATIVE_GAP * problem.size(x):
            break
        mu *= SHRINK
    slack = problem.coordinates.relative_inertias(x) - problem.margin * np.eye(4)
    return SolverResult(
        x=x,
        multipliers=Multipliers(mu * np.linalg.inv(slack), mu / problem.slack(x)),
        solver="barrier",
        status=f"centred to mu = {mu:.1e}",
        iterations=steps,
        seconds=time.perf_counter() - clock,
    )


@dataclass(frozen=True)
class _Path:
    problem: FeasibleProblem
    directions: Float[ndarray, "p free"] | None

    def centre(self, x: Float[ndarray, " p"], mu: float) -> tuple[Float[ndarray, " p"], int]:
        for taken in range(NEWTON_STEPS):
            gradient, hessian = self._derivatives(x, mu)
            step, decrease = self._newton(gradient, hessian)
            length, before = 1.0, self._value(x, mu)
            if decrease <= max(DECREMENT * mu, ROUNDING * abs(before)):
                return x + step if np.isfinite(self._value(x + step, mu)) else x, taken + 1
            while self._value(x + length * step, mu) > before - SUFFICIENT * length * decrease:
                length /= 2
                if length < LEAST_STEP:
                    # No descent is left to rounding: this is as central as numbers allow.
                    return x, taken + 1
            x = x + length * step
        raise SolverFailed(
            "no centre of the barrier", (f"barrier: mu = {mu:.1e}, {NEWTON_STEPS} Newton steps",)
        )

    def _newton(
        self, gradient: Float[ndarray, " p"], hessian: Float[ndarray, "p p"]
    ) -> tuple[Float[ndarray, " p"], float]:
        free = self.directions
        g = gradient if free is None else free.T @ gradient
        H = hessian if free is None else free.T @ hessian @ free
        # Unit diagonal: what is left of different scales must not cost digits.
        scale = 1 / np.sqrt(np.diag(H))
        try:
            scaled = H * np.outer(scale, scale) + JITTER * np.eye(len(g))
            step = -scale * cho_solve(cho_factor(scaled), scale * g)
        except np.linalg.LinAlgError as error:
            raise SolverFailed("no Newton step", (f"barrier: {error}",)) from error
        return (step if free is None else free @ step), float(-g @ step)

    def _value(self, x: Float[ndarray, " p"], mu: float) -> float:
        problem = self.problem
        slack = problem.slack(x)
        margins = np.linalg.eigvalsh(problem.coordinates.relative_inertias(x)) - problem.margin
        if not (np.all(margins > 0) and np.all(slack > 0)):
            return np.inf
        return problem.objective(x) - mu * float(np.log(margins).sum() + np.log(slack).sum())

    def _derivatives(
        self, x: Float[ndarray, " p"], mu: float
    ) -> tuple[Float[ndarray, " p"], Float[ndarray, "p p"]]:
        problem = self.problem
        gradient, hessian = problem.gradient(x), problem.hessian(x)
        above = problem.coordinates.relative_inertias(x) - problem.margin * np.eye(4)
        inertial = ENTRIES * problem.coordinates.links
        gradient[:inertial] -= mu * adjoint(np.linalg.inv(above))
        for link, block in enumerate(log_det_hessians(above)):
            place = slice(ENTRIES * link, ENTRIES * link + ENTRIES)
            hessian[place, place] += mu * block
        rows, slack = problem.inequality.matrix, problem.slack(x)
        gradient -= mu * rows.T @ (1 / slack)
        hessian += mu * (rows.T / slack**2) @ rows
        return gradient, hessian


def _start(problem: FeasibleProblem) -> Float[ndarray, " p"]:
    x = problem.coordinates.start
    if np.all(problem.slack(x) > 0) and not len(problem.equality):
        return x
    inner = most_interior(problem.coordinates, problem.inequality, problem.equality)
    if not inner.margin > problem.margin:
        raise SolverFailed(
            "no strictly feasible start", (f"barrier: largest margin {inner.margin:.1e}",)
        )
    return inner.x
