"""Which class of motions tells most, at equal CPU time?

    python -m studies.compare_trajectories [--seconds S] [--seeds N] [--smoke]

The paper's arm with the paper's limits, a UR5 and a Panda with those of their files, effort
included. Classes are compared seed by seed, by the same optimiser with the same CPU seconds.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from oed.commands.options import Count, parse
from oed.design.criteria import Criterion
from oed.design.default_limits import with_default_limits
from oed.design.default_problem import ProblemSettings, default_problem
from oed.design.design import Design
from oed.design.optimisers import interior_point
from oed.design.optimisers.result import Budget
from oed.design.problem import DesignProblem
from oed.design.still_joints import hold_still_joints
from oed.design.trajectories import FourierClass, SplineClass, TrajectoryClass
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.process_end import RESUMES, leave
from oed.robot import JointLimits, imi_scara, load_arm
from studies.case_runner import CaseRunner, Outcome, leave_page, work_through
from studies.data_folders import EXAMPLE_ROBOTS, PANDA
from studies.row_file import RowFile
from studies.study_options import CaseOptions
from studies.trajectory_summary import summarise

KEY = ("problem", "trajectory", "seed")
VALUES = (
    "variables",
    "base",
    "value",
    "J_k",
    "J_d_continuous",
    "certified_violation",
    "evaluations",
    "cpu_s",
    "status",
)
# That decide a line, with all that they import.
WORK = ("oed.design.design", "oed.design.default_problem", "oed.design.optimisers.interior_point")
UR5 = EXAMPLE_ROBOTS / "ur_description/urdf/ur5_robot.urdf"
# The paper's rows are 80 instants (Calafiore 2001, section 5). J_d is designed on three times as
# many, as its bound is on continuous time, which few instants would let a kink hide from.
PAPER_INSTANTS, J_D_INSTANTS = 80, 240
DIGITS = 4  # of a criterion that a budget of CPU time leaves
ARM_INSTANTS = 200  # the default of the command


@dataclass(frozen=True)
class Question:
    """What is to be designed.

    Attributes:
        arm: "paper", "ur5" or "panda".
        criterion: "J_k" or "J_d".
        horizon: [s]
        instants: Of the criterion.
    """

    arm: str
    criterion: Criterion
    horizon: float
    instants: int


QUESTIONS = {
    "panda": Question("panda", "J_d", 10.0, ARM_INSTANTS),
    "ur5": Question("ur5", "J_d", 10.0, ARM_INSTANTS),
    "paper, J_k, 10 s": Question("paper", "J_k", 10.0, PAPER_INSTANTS),
    "paper, J_k, 20 s": Question("paper", "J_k", 20.0, PAPER_INSTANTS),
    "paper, J_d": Question("paper", "J_d", 10.0, J_D_INSTANTS),
}
# The series of twenty harmonics was the paper's best so far, that of five is the default.
ON_ARMS = ("fourier 5", "fourier 20", "collocation 40")
ON_PAPER = ("fourier 20", "collocation 60")


@dataclass(frozen=True)
class Config:
    """What is compared.

    Attributes:
        seconds: CPU time of each design [s].
        seeds: Designs of each class and arm, one a seed.
        paper_seeds: Likewise of the paper's problems, where single designs are held to marks.
        problems: Names of questions.
    """

    seconds: float = 20.0
    seeds: int = 3
    paper_seeds: int = 1
    problems: tuple[str, ...] = tuple(QUESTIONS)

    def cases(self) -> list[Case]:
        """Arms before the paper; seed by seed, so that a study that is interrupted has pairs."""
        return [
            Case(problem, trajectory, seed, self.seconds)
            for is_paper, seeds in ((False, self.seeds), (True, self.paper_seeds))
            for seed in range(seeds)
            for problem in self.problems
            if (QUESTIONS[problem].arm == "paper") == is_paper
            for trajectory in (ON_PAPER if is_paper else ON_ARMS)
        ]


@dataclass(frozen=True)
class Case:
    """One design.

    Attributes:
        problem: Name of the question.
        trajectory: Name of the class and its harmonics or segments.
        seed: Of starts and hops.
        seconds: CPU time [s].
    """

    problem: str
    trajectory: str
    seed: int
    seconds: float

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        return self.problem, self.trajectory, str(self.seed)


def design(case: Case) -> Outcome:
    """One design, and what is proven of it; J_d in continuous time is that of 80 instants."""
    problem = pose(case)
    problem.cost_and_gradient(problem.random_start(np.random.default_rng(0)))  # compiled by now
    budget, rng = Budget(cpu_seconds=case.seconds), np.random.default_rng(case.seed)
    found = interior_point.optimise(problem, budget, rng)
    made = Design.from_result(problem, found)
    by_rows = len(problem.base) * float(np.log10(len(problem.instants) / PAPER_INSTANTS))
    value = 10**made.cost if problem.criterion == "J_k" else -made.cost
    return {
        "variables": problem.size,
        "base": len(problem.base),
        "value": round(value, DIGITS),
        "J_k": round(made.J_k, DIGITS),
        "J_d_continuous": round(made.J_d_continuous - by_rows, DIGITS),
        "certified_violation": made.certificate.violation,
        "evaluations": found.evaluations,
        "cpu_s": round(found.cpu_s, 1),
        "status": "ok" if made.certificate.is_feasible else "not proven",
    }


def pose(case: Case) -> DesignProblem:
    """The problem of a case; motions of arms start and end at rest, the paper's do not."""
    question = QUESTIONS[case.problem]
    if question.arm == "paper":
        robot = imi_scara()
        model = TorqueModel.standard(robot)
        motions = motions_of(case.trajectory, robot.limits, question.horizon, at_rest=False)
        instants = motions.instants(question.instants)
        base = base_parameters(model)
        return DesignProblem(model, base, motions, robot.limits, instants, question.criterion)
    robot, _ = hold_still_joints(load_arm(str({"panda": PANDA, "ur5": UR5}[question.arm])))
    robot, _ = with_default_limits(robot)
    motions = motions_of(case.trajectory, robot.limits, question.horizon, at_rest=True)
    settings = ProblemSettings(horizon=question.horizon, instants=question.instants)
    posed = default_problem(TorqueModel.standard(robot), settings).problem
    return dataclasses.replace(posed, trajectory=motions, instants=motions.instants(ARM_INSTANTS))


def motions_of(name: str, limits: JointLimits, horizon: float, *, at_rest: bool) -> TrajectoryClass:
    """The class of a name such as "fourier 5" or "collocation 40"."""
    family, count = name.split()
    if family == "fourier":
        return FourierClass(horizon, limits, int(count), at_rest)
    return SplineClass(horizon, limits, int(count), at_rest=at_rest)


@dataclass(frozen=True)
class Options(CaseOptions):
    """Which class of motions tells most, at equal CPU time?

    Attributes:
        seconds: CPU time of each design [s].
        seeds: Designs of each class and arm.
    """

    study: ClassVar[str] = "compare_trajectories"
    names: ClassVar[tuple[str, ...]] = ("summary.md", "provenance.json")

    seconds: float = Config.seconds
    seeds: Count = Config.seeds

    @property
    def config(self) -> Config:
        """What is compared."""
        if self.smoke:
            return Config(0.2, problems=("paper, J_k, 10 s",))
        return Config(self.seconds, self.seeds)


def runner(out: Path) -> CaseRunner[Case]:
    """What works through the cases and keeps their lines in a folder."""
    return CaseRunner(design, RowFile(out / "runs.csv", KEY, VALUES), "designs", code=WORK)


def write(config: Config, rows: RowFile, out: Path) -> None:
    """Leave the summary and provenance beside the rows."""
    chosen = rows.rows_of(case.key for case in config.cases())
    leave_page(summarise(chosen, config.seconds), config, None, out)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    options = parse(Options, prog="python -m studies.compare_trajectories", arguments=arguments)
    config = options.config
    todo = runner(options.results)
    return work_through(
        todo, config.cases(), options, config, lambda out: write(config, todo.rows, out)
    )


if __name__ == "__main__":
    leave(main, "studies.compare_trajectories", RESUMES)
