"""How far is the best excitation from anything possible?

    python -m studies.optimality_bound --out DIR [--degrees 0 2 4 6] [--seconds S] [--smoke]

Bounds the information of every motion of the paper's arm within its limits, whatever its
parametrisation, and holds designs of several classes against it.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from oed.commands.options import Count, Seed, parse
from oed.design.bound.information_bound import BoundSettings, InformationBound, information_bound
from oed.design.criteria import log10_det
from oed.design.optimisers import hopping, interior_point, slsqp
from oed.design.optimisers.result import Budget
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass, HarmonicClass, TrajectoryClass
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.process_end import leave
from oed.report.json_file import write_atomically
from oed.report.progress import progress
from oed.report.provenance import Provenance
from oed.report.table import markdown_table, write_csv
from oed.robot import JointLimits, load_robot
from studies.study_options import StudyOptions

INSTANTS = 80
OPTIMISERS = {
    "slsqp": slsqp.optimise,
    "interior-point": interior_point.optimise,
    "hopping": hopping.optimise,
}
# Values of an earlier study of this problem, to be reached or beaten.
EARLIER = {"fourier": 0.54, "harmonic": 0.525}


@dataclass(frozen=True)
class Config:
    """What is bounded.

    Attributes:
        degrees: Total degrees of the test functions, one bound each.
        horizons: Of the Fourier designs [s].
        harmonics: Of the Fourier designs.
        cpu_seconds: Spent on each design [s].
        seed: Of designs and random states.
        bound: Settings of the bound.
    """

    degrees: tuple[int, ...] = (0, 2, 4, 6)
    horizons: tuple[float, ...] = (10.0,)
    harmonics: tuple[int, ...] = (5, 10, 20)
    cpu_seconds: float = 20.0
    seed: int = 0
    bound: BoundSettings = field(default_factory=BoundSettings)


Rows = list[dict[str, str | int | float]]


def run(config: Config) -> tuple[Rows, Rows]:
    """Bounds by degree, and designs with their efficiency against the best bound."""
    robot = load_robot("builtin:imi_scara")
    model = TorqueModel.standard(robot)
    base = base_parameters(model)
    bounds: list[InformationBound] = []
    rows: Rows = []
    for degree in progress(config.degrees, "bounds"):
        started = time.process_time()
        settings = replace(config.bound, degree=degree)
        rng = np.random.default_rng(config.seed)
        bound = information_bound(model, base, robot.limits, rng, settings=settings)
        bounds.append(bound)
        rows.append(_bound_row(degree, bound, time.process_time() - started))
    best = min(bounds, key=lambda bound: bound.log10_det)
    cases = [
        (*named, optimiser) for named in _classes(robot.limits, config) for optimiser in OPTIMISERS
    ]
    designs: Rows = []
    for label, motions, optimiser in progress(cases, "designs"):
        instants = motions.instants(INSTANTS)
        problem = DesignProblem(model, base, motions, robot.limits, instants, "J_d")
        designs.append({"class": label, **_design_row(problem, optimiser, best, config)})
    return rows, designs


def _classes(limits: JointLimits, config: Config) -> list[tuple[str, TrajectoryClass]]:
    fourier: list[tuple[str, TrajectoryClass]] = [
        (f"fourier, {harmonics} harmonics, {horizon:g} s", FourierClass(horizon, limits, harmonics))
        for horizon in config.horizons
        for harmonics in config.harmonics
    ]
    harmonic: list[tuple[str, TrajectoryClass]] = [
        (f"harmonic, W = 3, {horizon:g} s", HarmonicClass.exact(limits, horizon))
        for horizon in config.horizons
    ]
    return fourier + harmonic


def _bound_row(
    degree: int, bound: InformationBound, seconds: float
) -> dict[str, str | int | float]:
    return {
        "degree": degree,
        "test_functions": bound.functions,
        "kind": bound.kind,
        "J_d_bound": bound.J_d(INSTANTS),
        "J_d_of_best_measure": bound.attained + bound.size * float(np.log10(INSTANTS)),
        "dual_excess": bound.excess,
        "boxes": bound.boxes,
        "cpu_s": seconds,
    }


def _design_row(
    problem: DesignProblem, optimiser: str, bound: InformationBound, config: Config
) -> dict[str, str | int | float]:
    """Design, and hold it against the bound; a motion that does not return pays for that."""
    rng = np.random.default_rng(config.seed)
    result = OPTIMISERS[optimiser](problem, Budget(cpu_seconds=config.cpu_seconds), rng)
    J_d = log10_det(problem.continuous_information(result.z))
    horizon = None if problem.trajectory.is_periodic else problem.trajectory.horizon
    return {
        "optimiser": optimiser,
        "J_d": -result.cost,
        "J_d_continuous": J_d,
        "J_d_bound": bound.J_d(INSTANTS, horizon),
        "d_efficiency": bound.efficiency(J_d, INSTANTS, horizon),
        "certified_violation": problem.certificate(result.z).violation,
        "cpu_s": result.cpu_s,
    }


def write(result: tuple[Rows, Rows], config: Config, out: Path) -> None:
    """Leave bounds.csv, designs.csv, summary.md and provenance.json."""
    bounds, designs = result
    write_csv(out / "bounds.csv", bounds)
    write_csv(out / "designs.csv", designs)
    best = min(float(row["J_d_bound"]) for row in bounds)
    text = f"""\
# How far from anything possible

The paper's arm and limits, {INSTANTS} instants, 160 rows, R_v = I, logarithms to base 10. No periodic
motion within the limits, of any parametrisation, has a continuous-time J_d above **{best:.4f}**:
the dual of the relaxation was checked over the whole set of states by branch and bound.
For a motion that does not return, the bound allows for a way back of the longest duration that
any two states can need; it holds for motions that the arm can come to from rest and stop after.

{markdown_table(bounds)}
Designs ({config.cpu_seconds:g} CPU seconds each, from one seed) against the best of these bounds. An earlier study
certified {EARLIER["fourier"]} for periodic motions and {EARLIER["harmonic"]} for free frequencies.

{markdown_table(designs)}"""
    write_atomically(out / "summary.md", text)
    Provenance.collect(config, seed=config.seed).write(out / "provenance.json")


@dataclass(frozen=True)
class Options(StudyOptions):
    """How far any motion could still be better: a bound on the information.

    Attributes:
        degrees: Total degrees of the test functions, one bound each.
        seconds: CPU time of each design [s].
        seed: Of designs and random states.
    """

    study: ClassVar[str] = "optimality_bound"
    names: ClassVar[tuple[str, ...]] = (
        "bounds.csv",
        "designs.csv",
        "summary.md",
        "provenance.json",
    )

    degrees: tuple[Count, ...] = Config.degrees
    seconds: float = Config.cpu_seconds
    seed: Seed = Config.seed

    @property
    def config(self) -> Config:
        """What is bounded."""
        if not self.smoke:
            return Config(degrees=self.degrees, cpu_seconds=self.seconds, seed=self.seed)
        quick = BoundSettings(first_atoms=800, states_per_round=4000, proof_tolerance=0.03)
        return Config((2,), harmonics=(3,), cpu_seconds=0.3, seed=self.seed, bound=quick)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    options = parse(Options, prog="python -m studies.optimality_bound", arguments=arguments)
    with options.held() as results:
        found = run(options.config)
        with results.replaced() as new:
            write(found, options.config, new)
    return 0


if __name__ == "__main__":
    leave(main, "studies.optimality_bound")
