"""One run of an optimiser on a design problem, its whole search logged.

Every point at which the optimiser asks for a gradient is kept with the CPU time, and judged after the
run: brought within the limits and evaluated exactly, off the clock. A run that had ended there would have
done the same with the point that it was at. So one long run can be read at every shorter budget.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.criteria import Criterion, condition, log10_det
from oed.design.optimisers import evolution, genetic, hopping, interior_point, random_search, slsqp
from oed.design.optimisers.result import Budget, HistoryPoint
from oed.design.optimisers.target_hits import compress, write_history
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass
from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.robot import Robot, arm_joints, imi_scara, load_robot
from studies.data_folders import PANDA
from studies.row_file import Outcome

OPTIMISERS = {
    "random": random_search.optimise,
    "genetic": genetic.optimise,
    "cma-es": evolution.optimise,
    "slsqp": slsqp.optimise,
    "hopping": hopping.optimise,
    "interior-point": interior_point.optimise,
}
PROBLEMS = ("paper", "panda")
HORIZON = 10.0  # [s]
INSTANTS = 80  # the paper's, section 5
HARMONICS = 5  # the default of the command
# The URDF has none. Franka Emika, "Control parameters specifications", joint space, q-double-dot max.
PANDA_ACCELERATION = (15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0)  # [rad/s^2]
# Points closer in time than this share of the time that has passed are judged as one: it moves no
# reading by more, and a minute's tens of thousands of points by a tenth of the time they took.
APART = 1e-3

KEY = ("problem", "criterion", "optimiser", "seed", "cpu_budget_s")
VALUES = (
    "status",
    "base",
    "evaluations",
    "judged",
    "cpu_s",
    "J_k",
    "J_d",
    "certified_violation",
    "history",
)
DIGITS = 6  # of a criterion that a budget of CPU time leaves


@dataclass(frozen=True)
class Case:
    """One run.

    Attributes:
        problem: "paper" or "panda".
        criterion: "J_k" or "J_d".
        optimiser: Name in `OPTIMISERS`.
        seed: Of all its draws.
        seconds: CPU time [s].
        read_at: CPU times at which the run is read, besides its end [s].
    """

    problem: str
    criterion: Criterion
    optimiser: str
    seed: int
    seconds: float
    read_at: tuple[float, ...]

    @property
    def key(self) -> tuple[str, ...]:
        """As text, in the order of `KEY`."""
        return self.problem, self.criterion, self.optimiser, str(self.seed), str(self.seconds)


@dataclass(frozen=True)
class LoggedProblem(DesignProblem):
    """A problem that keeps where its gradient was asked for.

    Attributes:
        asked: CPU time of the process [s] and point, in order; to be cleared before a run.
    """

    asked: list[tuple[float, ndarray]] = field(default_factory=list)

    def cost_and_gradient(
        self, z: Float[ndarray, " size"], **how: float | None
    ) -> tuple[float, Float[ndarray, " size"]]:
        """As of the problem itself, and logged."""
        self.asked.append((time.process_time(), np.array(z)))
        return super().cost_and_gradient(z, **how)  # pyright: ignore[reportArgumentType]  # its own


def run_case(case: Case) -> Outcome:
    """Optimise, judge all that was visited, and certify the best of it."""
    problem = build_problem(case.problem, case.criterion)
    problem.asked.clear()
    started, rng = time.process_time(), np.random.default_rng(case.seed)
    result = OPTIMISERS[case.optimiser](problem, Budget(cpu_seconds=case.seconds), rng)
    points = list(spaced([(at - started, z) for at, z in problem.asked]))
    found = judged(problem, points)
    trace = improvements([*result.history, *(point for point, _ in found)], case.seconds)
    best = min(found, key=lambda pair: pair[0].cost, default=None)
    z = result.z if best is None or result.cost <= best[0].cost else best[1]
    information = problem.information(z)
    return {
        "status": result.status,
        "base": len(problem.base),
        "evaluations": result.evaluations,
        "judged": len(found),
        "cpu_s": round(result.cpu_s, 3),
        "J_k": round(condition(information), DIGITS),
        "J_d": round(log10_det(information), DIGITS),
        "certified_violation": problem.certificate(z).violation,
        "history": write_history(compress(trace, read_at=(*case.read_at, case.seconds))),
    }


def spaced(asked: Sequence[tuple[float, ndarray]]) -> Iterator[tuple[float, ndarray]]:
    """The points that come at least `APART` after the one before; finite ones alone."""
    before = 0.0
    for at, z in asked:
        if at - before >= APART * at and np.isfinite(z).all():
            before = at
            yield at, z


def judged(
    problem: DesignProblem, points: Sequence[tuple[float, ndarray]]
) -> list[tuple[HistoryPoint, ndarray]]:
    """Each point within the limits, and its exact cost at the time when it was visited."""
    found = []
    for number, (at, z) in enumerate(points, start=1):
        within = problem.quick_repair(z)
        found.append((HistoryPoint(number, at, problem.cost(within)), within))
    return found


def improvements(points: Sequence[HistoryPoint], until: float) -> tuple[HistoryPoint, ...]:
    """The points by a CPU time [s] that were the best so far, in order of time."""
    best, kept = np.inf, []
    for point in sorted(points, key=lambda point: point.cpu_s):
        if point.cpu_s <= until and point.cost < best:
            best = point.cost
            kept.append(point)
    return tuple(kept)


@lru_cache(maxsize=4)
def build_problem(name: str, criterion: Criterion) -> LoggedProblem:
    """The problem, compiled and warmed up, so that no run pays for that."""
    model, base = _model(name)
    limits = model.robot.limits
    motions = FourierClass(HORIZON, limits, HARMONICS)
    problem = LoggedProblem(model, base, motions, limits, motions.instants(INSTANTS), criterion)
    start = problem.random_start(np.random.default_rng(0))
    problem.cost(start)
    problem.cost_and_gradient(start)
    problem.certificate(start)
    return problem


@lru_cache(maxsize=2)
def _model(name: str) -> tuple[TorqueModel, BaseParameters]:
    model = TorqueModel.standard(_robot(name))
    return model, base_parameters(model)


def _robot(name: str) -> Robot:
    if name == "paper":
        return imi_scara()
    if name == "panda":
        robot = load_robot(PANDA, joints=arm_joints(PANDA))
        acceleration = np.array(PANDA_ACCELERATION)
        both = np.stack([-acceleration, acceleration], axis=1)
        return robot.with_limits(robot.limits.with_(acceleration=both))
    raise ValueError(f"no problem {name!r}; there are {' and '.join(PROBLEMS)}")
