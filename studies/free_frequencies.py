"""How good can free frequencies be, what does that take, and on what bounds does it depend?

    python -m studies.free_frequencies --out DIR [--workers N | --scheduler ADDRESS] [--smoke]

Designs of the paper's arm in its class (10), W = 3, under the exact limits at all times: from
several seeds at the reference bounds, then for other bounds on the amplitudes and other horizons.
Start the same command again after an interruption: lines that are there are kept, and nothing is
written where nothing is left to do.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import ClassVar

import numpy as np

from oed.commands.options import parse
from oed.design.criteria import Criterion
from oed.design.design import Design
from oed.design.optimisers import hopping
from oed.design.optimisers.result import Budget
from oed.design.optimisers.target_hits import compress, write_history
from oed.design.problem import DesignProblem
from oed.design.trajectories import HarmonicClass
from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.process_end import RESUMES, leave
from oed.report.provenance import Provenance
from oed.robot import load_robot
from studies.case_runner import CaseRunner, Outcome, RowFile, work_through
from studies.free_frequency_summary import write_summary
from studies.study_options import CaseOptions

INSTANTS = 80  # the paper's, section 5

KEY = ("amplitude_bound", "horizon", "criterion", "seed", "cpu_budget_s")
VALUES = (
    "status",
    "evaluations",
    "cpu_s",
    "J_k",
    "J_d",
    "J_k_continuous",
    "J_d_continuous",
    "certified_violation",
    "largest_amplitude",
    "amplitude",
    "frequency",
    "history",
)


@dataclass(frozen=True)
class Config:
    """What is designed.

    Attributes:
        amplitude_bounds: Bounds on |a_jk| tried at the reference horizon [rad].
        horizons: Tried at the reference amplitude bound [s].
        reference: Amplitude bound [rad] and horizon [s] of the rest.
        criteria: Criteria.
        reference_seeds: Seeds at the reference.
        seeds: Seeds elsewhere.
        cpu_seconds: Of each run, by criterion in turn [s].
    """

    amplitude_bounds: tuple[float, ...] = (1.0, 1.57, 2.0, 4.0, 8.0)
    horizons: tuple[float, ...] = (5.0, 10.0, 20.0)
    reference: tuple[float, float] = (4.0, 10.0)
    criteria: tuple[Criterion, ...] = ("J_k", "J_d")
    reference_seeds: int = 4
    seeds: int = 1
    cpu_seconds: tuple[float, ...] = (60.0, 20.0)

    @classmethod
    def smoke(cls) -> Config:
        """Small enough for a test."""
        return cls((2.0, 4.0), (10.0,), reference_seeds=2, cpu_seconds=(0.5, 0.5))

    def cases(self) -> list[Case]:
        """The reference first, then what differs from it in one bound."""
        amplitude, horizon = self.reference
        others = [(a, horizon) for a in self.amplitude_bounds if a != amplitude]
        others += [(amplitude, t) for t in self.horizons if t != horizon]
        places = [(*self.reference, self.reference_seeds), *((*p, self.seeds) for p in others)]
        return [
            Case(a, t, criterion, seed, seconds)
            for a, t, seeds in places
            for seed in range(seeds)
            for criterion, seconds in zip(self.criteria, self.cpu_seconds, strict=True)
        ]


@dataclass(frozen=True)
class Case:
    """One run."""

    amplitude_bound: float
    horizon: float
    criterion: Criterion
    seed: int
    cpu_seconds: float

    @property
    def key(self) -> tuple[str, ...]:
        """As text, in the order of `KEY`."""
        return tuple(map(str, dataclasses.astuple(self)))


def run_case(case: Case) -> Outcome:
    """Design, prove and describe."""
    problem = build_problem(case)
    rng = np.random.default_rng(case.seed)
    found = hopping.optimise(problem, Budget(cpu_seconds=case.cpu_seconds), rng)
    design = Design.from_result(problem, found, optimiser="hopping", seed=case.seed)
    amplitude, frequency = (design.coefficients[k] for k in ("amplitude", "frequency"))
    return {
        "status": str(design.status),
        "evaluations": design.evaluations,
        "cpu_s": round(design.cpu_s, 3),
        "J_k": design.J_k,
        "J_d": design.J_d,
        "J_k_continuous": design.J_k_continuous,
        "J_d_continuous": design.J_d_continuous,
        "certified_violation": design.certificate.violation,
        "largest_amplitude": float(np.abs(amplitude).max()),
        "amplitude": " ".join(f"{a:.12g}" for a in amplitude.reshape(-1)),
        "frequency": " ".join(f"{w:.12g}" for w in frequency.reshape(-1)),
        "history": write_history(compress(found.history)),
    }


def build_problem(case: Case) -> DesignProblem:
    """The paper's arm with the bounds of a case, compiled."""
    model, base = _model()
    motions = HarmonicClass.exact(
        model.robot.limits, case.horizon, amplitude_bound=case.amplitude_bound
    )
    problem = DesignProblem(
        model, base, motions, model.robot.limits, motions.instants(INSTANTS), case.criterion
    )
    problem.cost_and_gradient(problem.random_start(np.random.default_rng(0)))
    return problem


@lru_cache(maxsize=1)
def _model() -> tuple[TorqueModel, BaseParameters]:
    model = TorqueModel.standard(load_robot("builtin:imi_scara"))
    return model, base_parameters(model)


def runner(out: Path) -> CaseRunner[Case]:
    """What works through the cases, with its lines in `out`/runs.csv."""
    return CaseRunner(run_case, RowFile(out / "runs.csv", KEY, VALUES), "designs")


def write(config: Config, rows: RowFile, out: Path) -> None:
    """Leave summary, figure and provenance beside the rows."""
    chosen = rows.rows_of(case.key for case in config.cases())
    write_summary(chosen, config.reference, out)
    Provenance.collect(config, seed=None).write(out / "provenance.json")


@dataclass(frozen=True)
class Options(CaseOptions):
    """What do free frequencies under exact limits reach, and at what cost?"""

    study: ClassVar[str] = "free_frequencies"
    names: ClassVar[tuple[str, ...]] = (
        "summary.md",
        "provenance.json",
        "dependence.png",
        "dependence.pdf",
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    options = parse(Options, prog="python -m studies.free_frequencies", arguments=arguments)
    config = Config.smoke() if options.smoke else Config()
    todo = runner(options.results)
    return work_through(
        todo, config.cases(), options, config, lambda out: write(config, todo.rows, out)
    )


if __name__ == "__main__":
    leave(main, "studies.free_frequencies", RESUMES)
