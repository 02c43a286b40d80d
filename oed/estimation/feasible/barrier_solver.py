"""The problem by Newton steps on a sequence of barriers, sharing nothing with conic solvers.

Boyd and Vandenberghe, Convex Optimization (2004), chapter 11: minimise the objective plus mu
times the logarithmic barrier of the demands, for mu falling to rounding. The log-det pull is
kept as it is, smooth and exact, where a conic solver needs further cones for it.

Every term's Hessian is F^T F and its gradient F^T r for known F and r, so that a Newton step is
a linear least-squares problem: its QR factor sees the condition of F, where the normal equations
would see the square of it and lose the unknowns that a weak pull alone decides (Golub and Van
Loan, Matrix Computations (2013), section 5.3).
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import null_space, solve_triangular

from oed.estimation.feasible.conic_solver import SolverResult
from oed.estimation.feasible.coordinates import BASIS, ENTRIES
from oed.estimation.feasible.interior import SolverFailed, most_interior
from oed.estimation.feasible.optimality import Multipliers
from oed.estimation.feasible.problem import FeasibleProblem
from oed.estimation.feasible.regularisation import quadratic_root

FIRST_BARRIER = 1.0
SHRINK = 0.1
RELATIVE_GAP = 1e-9
DECREMENT = 1e-9  # of the barrier: a centring this exact is far inside quadratic convergence
ROUNDING = 1e-14  # of the objective: no line search can see a smaller decrease
NEWTON_STEPS = 60
SUFFICIENT = 0.1  # Armijo's share of the predicted decrease
LEAST_STEP = 1e-12


def solve_barrier(
    problem: FeasibleProblem, start: Float[ndarray, " p"] | None = None
) -> SolverResult:
    """Solve by path-following Newton's method.

    Every point of the path is strictly feasible: where numbers end the path early, its last
    point is returned, and the check of optimality says what it is worth.

    Args:
        problem: To solve.
        start: A strictly feasible point; the reference, or the most interior point, if None.

    Raises:
        SolverFailed: If a strictly feasible start cannot be found.
    """
    clock = time.perf_counter()
    x = _start(problem) if start is None else start
    demands = 4 * problem.coordinates.links + len(problem.inequality)
    path = _Path(problem, null_space(problem.equality.matrix) if len(problem.equality) else None)
    mu, steps = FIRST_BARRIER * problem.size(x) / demands, 0
    while True:
        x, taken, is_central = path.centre(x, mu)
        steps += taken
        if not is_central or mu * demands <= RELATIVE_GAP * problem.size(x):
            break
        mu *= SHRINK
    slack = problem.coordinates.relative_inertias(x) - problem.margin * np.eye(4)
    return SolverResult(
        x=x,
        multipliers=Multipliers(mu * np.linalg.inv(slack), mu / problem.slack(x)),
        solver="barrier",
        status=f"{'centred to' if is_central else 'left the path at'} mu = {mu:.1e}",
        iterations=steps,
        seconds=time.perf_counter() - clock,
    )


@dataclass(frozen=True)
class _Path:
    problem: FeasibleProblem
    directions: Float[ndarray, "p free"] | None

    def centre(self, x: Float[ndarray, " p"], mu: float) -> tuple[Float[ndarray, " p"], int, bool]:
        """The minimiser at mu, the Newton steps to it, and whether they were enough."""
        for taken in range(NEWTON_STEPS):
            step, decrease = self._newton(x, mu)
            length, before = 1.0, self._value(x, mu)
            if decrease <= max(DECREMENT * mu, ROUNDING * abs(before)):
                return x + step if np.isfinite(self._value(x + step, mu)) else x, taken + 1, True
            while self._value(x + length * step, mu) > before - SUFFICIENT * length * decrease:
                length /= 2
                if length < LEAST_STEP:
                    # No descent is left to rounding: this is as central as numbers allow.
                    return x, taken + 1, True
            x = x + length * step
        return x, NEWTON_STEPS, False

    def _newton(self, x: Float[ndarray, " p"], mu: float) -> tuple[Float[ndarray, " p"], float]:
        """The step, and the square of Newton's decrement."""
        F, r = self._rows(x, mu)
        F = F if self.directions is None else F @ self.directions
        # Columns of one length: what is left of different scales must not cost digits.
        lengths = np.linalg.norm(F, axis=0)
        Q, R = np.linalg.qr(F / lengths)
        step = solve_triangular(R, -(Q.T @ r)) / lengths
        decrease = float(-r @ (F @ step))
        return (step if self.directions is None else self.directions @ step), decrease

    def _value(self, x: Float[ndarray, " p"], mu: float) -> float:
        problem = self.problem
        slack = problem.slack(x)
        margins = np.linalg.eigvalsh(problem.coordinates.relative_inertias(x)) - problem.margin
        if not (np.all(margins > 0) and np.all(slack > 0)):
            return np.inf
        return problem.objective(x) - mu * float(np.log(margins).sum() + np.log(slack).sum())

    def _rows(
        self, x: Float[ndarray, " p"], mu: float
    ) -> tuple[Float[ndarray, "rows p"], Float[ndarray, " rows"]]:
        """F and r of the whole: Hessian F^T F, gradient F^T r."""
        problem, coordinates = self.problem, self.problem.coordinates
        inertias, pull = coordinates.relative_inertias(x), problem.regularisation
        inertial = ENTRIES * coordinates.links
        ties = np.sqrt(problem.tie_break[inertial:])
        parts = [
            (np.sqrt(2) * problem.factor, np.sqrt(2) * (problem.factor @ x - problem.target)),
            (np.eye(len(x))[inertial:] * ties[:, None], ties * x[inertial:]),
        ]
        if pull.kind == "quadratic":
            root = np.sqrt(pull.weight) * quadratic_root(coordinates)
            parts.append((root, root @ (x - coordinates.start)))
        else:
            parts.append(_log_det_rows(inertias, len(x), pull.weight, with_trace=True))
        above = inertias - problem.margin * np.eye(4)
        parts.append(_log_det_rows(above, len(x), mu, with_trace=False))
        rows, root_mu = problem.inequality.matrix, np.sqrt(mu)
        parts.append((root_mu * rows / problem.slack(x)[:, None], np.full(len(rows), -root_mu)))
        return np.vstack([F for F, _ in parts]), np.concatenate([r for _, r in parts])


def _log_det_rows(
    matrices: Float[ndarray, "links 4 4"], size: int, weight: float, *, with_trace: bool
) -> tuple[Float[ndarray, "inertial p"], Float[ndarray, " inertial"]]:
    """F and r of weight (-log det M, plus tr M if asked), summed over links.

    With M = L L^T and T_k = L^-1 B_k L^-T for a basis B_k, the Hessian's entries are <T_k, T_l>,
    and the gradient's -<T_k, I> without the trace, <T_k, L^T L - I> with it.
    """
    F, r = np.zeros((ENTRIES * len(matrices), size)), np.zeros(ENTRIES * len(matrices))
    for link, matrix in enumerate(matrices):
        lower = np.linalg.cholesky(matrix)
        inverse = np.linalg.inv(lower)
        turned = inverse @ BASIS @ inverse.T
        aim = (lower.T @ lower if with_trace else 0.0) - np.eye(4)
        place = slice(ENTRIES * link, ENTRIES * link + ENTRIES)
        F[place, place] = np.sqrt(weight) * np.einsum("aij,kij->ak", BASIS, turned)
        r[place] = np.sqrt(weight) * np.einsum("aij,ij->a", BASIS, aim)
    return F, r


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
