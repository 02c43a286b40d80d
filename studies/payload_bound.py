"""Can a designed motion of 3 s tell a mass as well as 20 s of general motion, and could any?

    python -m studies.payload_bound [--workers N] [--smoke] [--out results/payload_bound]

By the problem of `oed design --payload` itself, whose noise and errors of the arm are the same for all:
deviation of the mass by random motions, by designed ones, and below what no motion within the limits
comes. A random motion goes from rest to rest, near the limits of every joint.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.commands.options import parse
from oed.design.bound.least_deviation import least_deviation
from oed.design.load_problem import LoadProblem
from oed.design.optimisers.interior_point import optimise
from oed.design.optimisers.result import Budget
from oed.process_end import RESUMES, leave
from oed.report.table import Row, markdown_table
from studies.case_runner import CaseRunner, Outcome, RowFile, leave_page, work_through
from studies.payload_motion import EVALUATIONS, problem_of
from studies.study_options import CaseOptions

RUNS = "runs.csv"
KEY_COLUMNS = ("arm", "how", "seconds")
VALUE_COLUMNS = ("status", "mass", "centre", "cpu")
RANDOM = 10  # motions, of whose deviations the median counts
RATE = 200 / 3  # [Hz] of instants: those of the designs
# Harmonics a second of motion: the highest of a random motion is that of the designs.
HARMONICS = 5 / 3
How = Literal["random", "fourier", "collocation", "bound"]


@dataclass(frozen=True)
class Case:
    """One way to tell a load on one arm.

    Attributes:
        arm: Key of the arm.
        how: Random motions, a designed one of a class, or the bound.
        seconds: Length of the motion.
        evaluations: Of a design.
    """

    arm: str
    how: How
    seconds: float
    evaluations: int = EVALUATIONS

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        return (self.arm, self.how, f"{self.seconds:g}")


@dataclass(frozen=True)
class Config:
    """What is compared.

    Attributes:
        arms: Keys.
        ways: With their lengths [s].
        evaluations: Of a design.
    """

    arms: tuple[str, ...] = ("ur5", "panda", "scara")
    ways: tuple[tuple[How, float], ...] = (
        ("random", 3.0),
        ("random", 10.0),
        ("random", 20.0),
        ("fourier", 3.0),
        ("collocation", 3.0),
        ("bound", 3.0),
    )
    evaluations: int = EVALUATIONS


SMOKE = Config(arms=("scara",), ways=(("random", 3.0), ("bound", 3.0)))


def cases_of(config: Config) -> list[Case]:
    """All of them."""
    return list(_cases(config))


def _cases(config: Config) -> Iterator[Case]:
    for arm in config.arms:
        for how, seconds in config.ways:
            yield Case(arm, how, seconds, config.evaluations)


def work(case: Case) -> Outcome:
    """Deviations of mass and centre that a way leaves."""
    start = time.process_time()
    rng = np.random.default_rng(0)
    # The arm is known in one way for all: as a general motion of the designs' class tells it.
    known = problem_of(case.arm, 3.0)
    if case.how == "bound":
        (mass,) = (k for k, name in enumerate(known.base.names) if name.startswith("load_m_"))
        found = np.array([least_deviation(known, mass, rng).lower, np.nan])
    elif case.how == "random":
        problem = _as_well_known(_long(case), known)
        starts = [problem.random_start(rng) for _ in range(RANDOM)]
        found = np.median([_deviations(problem, z) for z in starts], axis=0)
    else:
        problem = _as_well_known(problem_of(case.arm, case.seconds, trajectory=case.how), known)
        result = optimise(problem, Budget(case.evaluations, None), rng)
        found = _deviations(problem, problem.repair(result.z))
    mass, centre = (float(x) for x in found)
    return {"status": "ok", "mass": mass, "centre": centre, "cpu": time.process_time() - start}


def _long(case: Case) -> LoadProblem:
    """The problem of motions of a length, as fast and as densely sampled as the designs."""
    return problem_of(
        case.arm,
        case.seconds,
        harmonics=round(HARMONICS * case.seconds),
        instants=round(RATE * case.seconds),
    )


def _as_well_known(problem: LoadProblem, known: LoadProblem) -> LoadProblem:
    return dataclasses.replace(problem, known=known.known)


def _deviations(problem: LoadProblem, z: Float[ndarray, " size"]) -> Float[ndarray, "2"]:
    """Of the mass [kg], and the largest of a first moment [kg m]."""
    deviations = np.sqrt(np.diag(np.linalg.inv(problem.information(z, scaled=False))))
    names = problem.base.names
    moments = [x for x, name in zip(deviations, names, strict=True) if name.startswith("load_m")]
    return np.array([moments[0], max(moments[1:])])


def page(rows: Sequence[dict[str, str]]) -> str:
    """The rows as a page."""
    good = [row for row in rows if row["status"] == "ok"]
    return (
        "# How well a load can be told in three seconds\n\n"
        "Standard deviation of the mass by the problem that `oed design --payload` solves, and that over the "
        "deviation by 20 s of random motion (the median of ten). All motions are from rest to rest within 90 % of the "
        "limits; the arm is known as 30 s of random motion tell it. `bound`: no motion of 3 s within the limits, "
        "of whatever class, has less, as far as a search over states went; it need not be reached, as "
        "states are taken there with no way from one to the next. Where it is above 1, nothing that moves for 3 s "
        "tells the mass as well as 20 s do: twenty seconds have 6.7 times the samples, and a random motion already "
        "has most of what each can tell.\n\n" + markdown_table(_rows(good), digits=3)
    )


def _rows(rows: Sequence[dict[str, str]]) -> list[Row]:
    found: list[Row] = []
    for arm in dict.fromkeys(row["arm"] for row in rows):
        own = [row for row in rows if row["arm"] == arm]
        longest = max(
            (row for row in own if row["how"] == "random"), key=lambda r: float(r["seconds"])
        )
        for row in own:
            mass = float(row["mass"])
            found.append(
                {
                    "arm": arm,
                    "motion": row["how"],
                    "seconds": float(row["seconds"]),
                    "mass [kg]": mass,
                    f"over random {float(longest['seconds']):g} s": mass / float(longest["mass"]),
                    "first moment [kg m]": float(row["centre"]),
                    "CPU s": float(row["cpu"]),
                }
            )
    return found


@dataclass(frozen=True)
class Options(CaseOptions):
    """Can a designed motion of 3 s tell a mass as well as 20 s of general motion, and could any?"""

    study: ClassVar[str] = "payload_bound"
    names: ClassVar[tuple[str, ...]] = ("summary.md", "provenance.json")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 1 if all failed, else 0."""
    options = parse(Options, prog="python -m studies.payload_bound", arguments=arguments)
    config = SMOKE if options.smoke else Config()
    rows = RowFile(options.results / RUNS, KEY_COLUMNS, VALUE_COLUMNS)
    return work_through(
        CaseRunner(work, rows, "payload_bound"),
        cases_of(config),
        options,
        config,
        lambda out: leave_page(page(rows.rows()), config, None, out),
    )


if __name__ == "__main__":
    leave(main, "studies.payload_bound", RESUMES)
