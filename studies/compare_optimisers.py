"""Which optimiser designs the best excitation, at equal evaluations and at equal CPU time?

    python -m studies.compare_optimisers --out DIR [--workers N | --scheduler ADDRESS] [--smoke]

Every problem x class x criterion x optimiser x seed is a line of runs.csv. A run goes on until it
has used both budgets, and is read at each of them. Start the same command again after an
interruption: lines that are there are kept.
"""

from __future__ import annotations

import dataclasses
import itertools
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy import ndarray

from oed.commands.options import Count, parse
from oed.design.criteria import Criterion, condition, log10_det
from oed.design.optimisers import evolution, genetic, hopping, interior_point, random_search, slsqp
from oed.design.optimisers.result import Budget, OptimiserResult
from oed.design.optimisers.target_hits import compress, cost_at, write_history
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass, HarmonicClass, TrajectoryClass
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.process_end import RESUMES, leave
from oed.report.provenance import Provenance
from oed.robot import JointLimits, Robot, arm_joints, load_robot
from studies.case_runner import CaseRunner, Outcome, RowFile, work_through
from studies.data_folders import PANDA
from studies.optimiser_summary import write_summary
from studies.study_options import CaseOptions

OPTIMISERS = {
    "genetic": genetic.optimise,
    "random": random_search.optimise,
    "cma-es": evolution.optimise,
    "slsqp": slsqp.optimise,
    "interior-point": interior_point.optimise,
    "hopping": hopping.optimise,
}
HORIZON = 10.0  # [s]
INSTANTS = 80  # the paper's, section 5
TERMS = 3  # the paper's W
HARMONICS = 5
# The URDF has none. Franka Emika, "Control parameters specifications", joint space, q-double-dot max.
PANDA_ACCELERATION = (15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0)  # [rad/s^2]

# A run that is slow at each evaluation is cut at this multiple of the CPU budget.
LONGEST = 2.5
# The arm is compared on the default class alone: the conservative one is the paper's.
PROBLEMS = (
    ("scara", "conservative"),
    ("scara", "harmonic"),
    ("scara", "fourier"),
    ("panda", "fourier"),
)

KEY = ("problem", "class", "criterion", "optimiser", "seed", "evaluations_budget", "cpu_budget_s")
VALUES = (
    "status",
    "evaluations",
    "cpu_s",
    "wall_s",
    "value",
    "value_at_evaluations",
    "value_at_cpu",
    "certified_violation",
    "J_k",
    "J_d",
    "J_k_continuous",
    "J_d_continuous",
    "history",
)


@dataclass(frozen=True)
class Config:
    """What is compared.

    Attributes:
        problems: Pairs of a problem, "scara" or "panda", and a trajectory class.
        criteria: Criteria.
        optimisers: Names in `OPTIMISERS`.
        seeds: Seeds 0 ... seeds - 1.
        evaluations: Budget of every run.
        cpu_seconds: Budget of every run [s].
    """

    problems: tuple[tuple[str, str], ...] = PROBLEMS
    criteria: tuple[Criterion, ...] = ("J_k", "J_d")
    optimisers: tuple[str, ...] = tuple(OPTIMISERS)
    seeds: int = 30
    evaluations: int = 500
    cpu_seconds: float = 1.0

    @classmethod
    def smoke(cls) -> Config:
        """Small enough for a test."""
        return cls((("scara", "fourier"),), ("J_k",), seeds=2, evaluations=60, cpu_seconds=0.05)

    def cases(self) -> list[Case]:
        """Every combination, seed by seed, so that an interrupted run compares all of them."""
        return [
            Case(*problem, criterion, optimiser, seed, self.evaluations, self.cpu_seconds)
            for seed, problem, criterion, optimiser in itertools.product(
                range(self.seeds), self.problems, self.criteria, self.optimisers
            )
        ]


@dataclass(frozen=True)
class Case:
    """One run."""

    problem: str
    trajectory: str
    criterion: Criterion
    optimiser: str
    seed: int
    evaluations: int
    cpu_seconds: float

    @property
    def key(self) -> tuple[str, ...]:
        """As text, in the order of `KEY`."""
        parts = (self.problem, self.trajectory, self.criterion, self.optimiser, self.seed)
        return tuple(map(str, (*parts, self.evaluations, self.cpu_seconds)))


def run_case(case: Case) -> Outcome:
    """Optimise, and certify what was found."""
    problem = build_problem(case.problem, case.trajectory, case.criterion)
    optimise = OPTIMISERS[case.optimiser]
    longest = LONGEST * case.cpu_seconds
    budget = Budget(case.evaluations, case.cpu_seconds, needs_both=True, longest=longest)
    rng = np.random.default_rng(case.seed)
    started = time.perf_counter()
    result = optimise(problem, budget, rng)
    wall = time.perf_counter() - started
    return _outcome(problem, case, result, wall)


def _outcome(problem: DesignProblem, case: Case, result: OptimiserResult, wall: float) -> Outcome:
    sampled = problem.information(result.z)
    average = problem.continuous_information(result.z)
    history = result.history
    return {
        "status": result.status,
        "evaluations": result.evaluations,
        "cpu_s": round(result.cpu_s, 4),
        "wall_s": round(wall, 4),
        "value": value_of(result.cost, case.criterion),
        "value_at_evaluations": value_of(
            cost_at(history, "evaluations", case.evaluations), case.criterion
        ),
        "value_at_cpu": value_of(cost_at(history, "cpu_s", case.cpu_seconds), case.criterion),
        "certified_violation": problem.certificate(result.z).violation,
        "J_k": condition(sampled),
        "J_d": log10_det(sampled),
        "J_k_continuous": condition(average),
        "J_d_continuous": log10_det(average),
        "history": write_history(compress(history)),
    }


def value_of(cost: float, criterion: str) -> float:
    """J_k or J_d of a problem's cost."""
    return 10.0**cost if criterion == "J_k" else -cost


@lru_cache(maxsize=8)
def build_problem(name: str, trajectory: str, criterion: Criterion) -> DesignProblem:
    """The problem, compiled and warmed up, so that no run pays for that."""
    robot = _robot(name)
    model, base = _model(name)
    motions = _trajectory(trajectory, robot.limits)
    problem = DesignProblem(
        model, base, motions, robot.limits, motions.instants(INSTANTS), criterion
    )
    start: ndarray = problem.random_start(np.random.default_rng(0))
    problem.cost(start)
    problem.cost_and_gradient(start)
    return problem


@lru_cache(maxsize=2)
def _model(name: str) -> tuple:
    model = TorqueModel.standard(_robot(name))
    return model, base_parameters(model)


def _robot(name: str) -> Robot:
    if name == "scara":
        return load_robot("builtin:imi_scara")
    if name == "panda":
        robot = load_robot(PANDA, joints=arm_joints(PANDA))
        acceleration = np.array(PANDA_ACCELERATION)
        both = np.stack([-acceleration, acceleration], axis=1)
        return robot.with_limits(robot.limits.with_(acceleration=both))
    raise ValueError(f"no problem {name!r}; there are 'scara' and 'panda'")


def _trajectory(name: str, limits: JointLimits) -> TrajectoryClass:
    if name == "conservative":
        return HarmonicClass.conservative(limits, HORIZON, TERMS)
    if name == "fourier":
        return FourierClass(HORIZON, limits, HARMONICS)
    if name == "harmonic":
        return HarmonicClass.exact(limits, HORIZON, TERMS)
    raise ValueError(f"no class {name!r}")


def runner(out: Path) -> CaseRunner[Case]:
    """What works through the cases, with its lines in `out`/runs.csv."""
    return CaseRunner(run_case, RowFile(out / "runs.csv", KEY, VALUES), "optimiser runs")


def write(config: Config, rows: RowFile, out: Path) -> None:
    """Leave summary, figure and provenance beside the rows."""
    sizes = {problem: len(_model(problem)[1]) for problem, _ in config.problems}
    chosen = rows.rows_of(case.key for case in config.cases())
    write_summary(chosen, sizes, LONGEST, out)
    Provenance.collect(config, seed=None).write(out / "provenance.json")


@dataclass(frozen=True)
class Options(CaseOptions):
    """Which optimiser wins where, at equal evaluations and equal CPU time?

    Attributes:
        seeds: Seeds a cell.
        optimisers: Which of them.
    """

    study: ClassVar[str] = "compare_optimisers"
    names: ClassVar[tuple[str, ...]] = (
        "summary.md",
        "provenance.json",
        "summary.csv",
        "target_hits.png",
        "target_hits.pdf",
    )

    seeds: Count = Config.seeds
    optimisers: tuple[str, ...] = Config.optimisers

    def __post_init__(self) -> None:
        super().__post_init__()
        if unknown := set(self.optimisers) - set(OPTIMISERS):
            raise ValueError(
                f"--optimisers {' '.join(sorted(unknown))}: there are {', '.join(OPTIMISERS)}"
            )

    @property
    def config(self) -> Config:
        """What is compared."""
        if self.smoke:
            return dataclasses.replace(Config.smoke(), optimisers=self.optimisers)
        return Config(seeds=self.seeds, optimisers=self.optimisers)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    options = parse(Options, prog="python -m studies.compare_optimisers", arguments=arguments)
    config = options.config
    todo = runner(options.results)
    return work_through(
        todo, config.cases(), options, config, lambda out: write(config, todo.rows, out)
    )


if __name__ == "__main__":
    leave(main, "studies.compare_optimisers", RESUMES)
