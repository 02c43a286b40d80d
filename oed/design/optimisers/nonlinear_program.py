"""A smooth objective under sampled limits, given to IPOPT through CasADi.

The Hessian of the Lagrangian is a dense damped BFGS matrix of our own: with tens of variables
and hundreds of limits, IPOPT's limited-memory update solves its large system once for every
remembered pair, and took five times longer.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.constraints import LimitConstraints
from oed.design.optimisers.bfgs import DampedBfgs
from oed.design.optimisers.held_interrupt import HeldInterrupt, hold_interrupt
from oed.design.optimisers.smooth_program import SINGULAR, LocalSolution, Spent, ValueAndGradient

CONVERGED = ("Solve_Succeeded", "Solved_To_Acceptable_Level")
WARM_BARRIER = 1e-3  # first barrier parameter of a start that is close to a solution


def solve_program(
    objective: ValueAndGradient,
    constraints: LimitConstraints,
    start: Float[ndarray, " size"],
    *,
    iterations: int,
    cpu_seconds: float = np.inf,
    is_warm: bool = False,
    tolerance: float = 1e-5,
) -> LocalSolution:
    """Minimise an objective under sampled limits and the box of the class, silently.

    Args:
        objective: Value and gradient by z.
        constraints: The limits.
        start: First point.
        iterations: Most to make.
        cpu_seconds: Most to spend [s].
        is_warm: Whether the start is close to a solution, and should stay so.
        tolerance: IPOPT's, on optimality and limits, with variables scaled to the box.
    """
    options = _options(iterations, tolerance, cpu_seconds, is_warm=is_warm)
    with hold_interrupt() as held:
        return _solve(_Scaled(objective, constraints, held), np.array(start), options)


def _options(
    iterations: int, tolerance: float, cpu_seconds: float, *, is_warm: bool
) -> dict[str, Any]:
    options: dict[str, Any] = {
        "ipopt.print_level": 0,
        "ipopt.sb": "yes",
        "print_time": False,
        "show_eval_warnings": False,
        "ipopt.max_iter": iterations,
        "ipopt.tol": tolerance,
        "ipopt.acceptable_tol": 10 * tolerance,
        "ipopt.mu_strategy": "adaptive",
    }
    if is_warm:
        options |= {"ipopt.mu_strategy": "monotone", "ipopt.mu_init": WARM_BARRIER}
        options |= {"ipopt.bound_push": WARM_BARRIER, "ipopt.bound_frac": WARM_BARRIER}
    if np.isfinite(cpu_seconds):
        options["ipopt.max_cpu_time"] = max(cpu_seconds, 1e-3)
    return options


def _solve(scaled: _Scaled, start: ndarray, options: dict[str, Any]) -> LocalSolution:
    constraints = scaled.constraints
    cost, hessian = _Objective(scaled), _Hessian(scaled)
    limits = _Limits(scaled) if constraints.count else None
    u = casadi.MX.sym("u", scaled.size)
    program = {"x": u, "f": cost(u), "g": casadi.MX(0, 1) if limits is None else limits(u)}
    solver = casadi.nlpsol("design", "ipopt", program, {**options, "hess_lag": hessian})
    answer = solver(
        x0=scaled.inward(start), lbx=-1.0, ubx=1.0, lbg=constraints.lower, ubg=constraints.upper
    )
    status = solver.stats()["return_status"]
    point = scaled.outward(np.asarray(answer["x"]).reshape(-1))
    if not np.isfinite(point).all():
        point = start
    return LocalSolution(point, scaled.evaluations, status in CONVERGED, status)


class _Scaled:
    """Objective and limits by u in [-1, 1]: box half widths make variables comparable.

    Remembers the last point, because IPOPT asks for value and gradient one after the other.
    """

    def __init__(
        self,
        objective: ValueAndGradient,
        constraints: LimitConstraints,
        held: HeldInterrupt,
    ) -> None:
        bounds = constraints.trajectory.bounds
        middle, half = bounds.mean(axis=1), np.diff(bounds)[:, 0] / 2
        self.evaluations = 0
        self.constraints = constraints
        self.size = len(middle)
        self.sparsity = casadi.Sparsity.triplet(
            constraints.count, self.size, constraints.rows.tolist(), constraints.columns.tolist()
        )
        # CasADi stores column by column; our entries come row by row.
        self._order = np.lexsort((constraints.rows, constraints.columns))
        self._objective, self._middle, self._half = objective, middle, half
        self._held, self._is_spent = held, False
        self._key, self._last = b"", (np.nan, np.zeros(0))
        self._jacobian: casadi.DM | None = None

    @property
    def is_over(self) -> bool:
        """Whether nothing more is to be evaluated."""
        return self._held.came or self._is_spent

    def inward(self, z: ndarray) -> ndarray:
        return (z - self._middle) / self._half

    def outward(self, u: ndarray) -> ndarray:
        return self._middle + self._half * u

    def objective(self, u: ndarray) -> tuple[float, ndarray]:
        try:
            return self._evaluated(u)
        except Spent:
            self._is_spent = True
        return np.nan, np.full(self.size, np.nan)  # IPOPT ends, silently unlike after an exception

    def _evaluated(self, u: ndarray) -> tuple[float, ndarray]:
        if self.is_over:
            raise Spent
        key = u.tobytes()
        if key != self._key:
            value, gradient = self._objective(self.outward(u))
            self._last = (value if np.isfinite(value) else SINGULAR, gradient * self._half)
            self._key = key
            self.evaluations += 1
        return self._last

    def limits(self, u: ndarray) -> ndarray:
        if self.is_over:  # while feasibility is restored, only limits are evaluated
            return np.full(self.constraints.count, np.nan)
        return self.constraints.values(self.outward(u))

    def jacobian(self, u: ndarray) -> casadi.DM:
        if self._jacobian is not None:
            return self._jacobian
        entries = self.constraints.jacobian_values(self.outward(u))
        entries = (entries * self._half[self.constraints.columns])[self._order]
        jacobian = casadi.DM(self.sparsity, entries)
        if self.constraints.trajectory.is_linear:
            self._jacobian = jacobian
        return jacobian

    def limit_gradient(self, u: ndarray, multipliers: ndarray) -> ndarray:
        limits = self.constraints
        weighted = limits.jacobian_values(self.outward(u)) * multipliers[limits.rows]
        return np.bincount(limits.columns, weighted, minlength=self.size) * self._half


class _Callback(casadi.Callback):
    """A function of Python to CasADi, given the sparsities of its inputs and its output."""

    def __init__(self, name: str, inputs: list[casadi.Sparsity], output: casadi.Sparsity) -> None:
        casadi.Callback.__init__(self)
        self._inputs, self._output = inputs, output
        self.construct(name, {})

    def get_n_in(self) -> int:
        return len(self._inputs)

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, i: int) -> casadi.Sparsity:
        return self._inputs[i]

    def get_sparsity_out(self, i: int) -> casadi.Sparsity:  # noqa: ARG002  # there is one
        return self._output


class _Objective(_Callback):
    def __init__(self, scaled: _Scaled) -> None:
        self._scaled = scaled
        super().__init__("objective", [_dense(scaled.size)], _dense(1))

    def eval(self, arguments: Sequence[casadi.DM]) -> list:
        return [self._scaled.objective(_flat(arguments[0]))[0]]

    def has_jacobian(self) -> bool:
        return True

    def get_jacobian(self, name: str, *_: object, **__: object) -> casadi.Function:
        scaled = self._scaled
        # Kept here, because CasADi does not keep a callback alive.
        self._derivative = _Derivative(
            name,
            [_dense(scaled.size), _dense(1)],
            casadi.Sparsity.dense(1, scaled.size),
            lambda u: casadi.DM(scaled.objective(u)[1]).T,
        )
        return self._derivative


class _Limits(_Callback):
    def __init__(self, scaled: _Scaled) -> None:
        self._scaled = scaled
        super().__init__("limits", [_dense(scaled.size)], _dense(scaled.constraints.count))

    def eval(self, arguments: Sequence[casadi.DM]) -> list:
        return [self._scaled.limits(_flat(arguments[0]))]

    def has_jacobian(self) -> bool:
        return True

    # Without this CasADi gives IPOPT a dense Jacobian, and an iteration takes five times longer.
    def has_jac_sparsity(self, *_: object, **__: object) -> bool:
        return True

    def get_jac_sparsity(self, *_: object, **__: object) -> casadi.Sparsity:
        return self._scaled.sparsity

    def get_jacobian(self, name: str, *_: object, **__: object) -> casadi.Function:
        scaled = self._scaled
        inputs = [_dense(scaled.size), _dense(scaled.constraints.count)]
        self._derivative = _Derivative(name, inputs, scaled.sparsity, scaled.jacobian)
        return self._derivative


class _Derivative(_Callback):
    """Jacobian of a callback: CasADi hands it the input and the output."""

    def __init__(
        self,
        name: str,
        inputs: list[casadi.Sparsity],
        output: casadi.Sparsity,
        evaluate: Callable[[ndarray], casadi.DM],
    ) -> None:
        self._evaluate = evaluate
        super().__init__(name, inputs, output)

    def eval(self, arguments: Sequence[casadi.DM]) -> list:
        return [self._evaluate(_flat(arguments[0]))]


class _Hessian(_Callback):
    """Upper triangle of the BFGS matrix, updated at every new point IPOPT asks at."""

    def __init__(self, scaled: _Scaled) -> None:
        self._scaled = scaled
        self._matrix = DampedBfgs(scaled.size)
        self._upper = np.triu_indices(scaled.size)
        # CasADi wants columns one after the other: the transpose of row order.
        self._order = np.lexsort(self._upper)
        inputs = [_dense(scaled.size), _dense(0), _dense(1), _dense(scaled.constraints.count)]
        super().__init__("hessian", inputs, casadi.Sparsity.upper(scaled.size))

    def eval(self, arguments: Sequence[casadi.DM]) -> list:
        u, weight, multipliers = _flat(arguments[0]), float(arguments[2]), _flat(arguments[3])
        scaled = self._scaled
        if weight > 0.0:  # it is 0 while IPOPT restores feasibility and ignores the objective
            multipliers = multipliers / weight
            is_linear = scaled.constraints.trajectory.is_linear

            def curved(at: ndarray) -> ndarray:
                return (
                    np.zeros(scaled.size) if is_linear else scaled.limit_gradient(at, multipliers)
                )

            self._matrix.update(u, scaled.objective(u)[1], curved)
        values = (self._matrix.matrix * weight)[self._upper][self._order]
        return [casadi.DM(casadi.Sparsity.upper(scaled.size), values)]


def _dense(rows: int) -> casadi.Sparsity:
    return casadi.Sparsity.dense(rows, 1)


def _flat(argument: casadi.DM) -> ndarray:
    return np.asarray(argument).reshape(-1)
