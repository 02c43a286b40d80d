"""Which optimiser designs the best excitation in 1, 10 and 60 CPU seconds?

    python -m studies.compare_optimisers [--seeds N N N] [--workers N | --scheduler ADDRESS] [--smoke]

On the paper's arm of two joints and on a Panda of seven, Fourier series of five harmonics, 80 instants.
Every problem x criterion x optimiser x seed is one run and one line of runs.csv, as long as its longest
budget, and read at each shorter one. Start the same command again after an interruption: lines that
are there are kept.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from oed.commands.options import Count, parse
from oed.design.criteria import Criterion
from oed.process_end import RESUMES, leave
from oed.report.provenance import Provenance
from studies.case_runner import CaseRunner, RowFile, work_through
from studies.optimiser_runs import KEY, OPTIMISERS, VALUES, Case, run_case
from studies.optimiser_summary import write_summary
from studies.study_options import CaseOptions

Cell = tuple[str, Criterion]  # problem, criterion
CELLS: tuple[Cell, ...] = (("paper", "J_k"), ("paper", "J_d"), ("panda", "J_d"))
GRADIENT = ("slsqp", "hopping", "interior-point")


@dataclass(frozen=True)
class Stage:
    """What is run to one budget; a run of a longer budget serves the shorter ones of its seed.

    Attributes:
        seconds: CPU time of each run [s].
        seeds: Seeds 0 ... seeds - 1.
        optimisers: Names in `OPTIMISERS`.
        cells: Problems and criteria.
    """

    seconds: float
    seeds: int
    optimisers: tuple[str, ...] = tuple(OPTIMISERS)
    cells: tuple[Cell, ...] = CELLS


# A minute each is for what is still moving by then: the paper's J_d is not, after ten seconds. Of the
# methods without gradients CMA-ES was ahead of both others wherever an earlier state of this study went on.
STAGES = (
    Stage(1.0, 10),
    Stage(10.0, 5, ("cma-es", *GRADIENT)),
    Stage(60.0, 1, GRADIENT, (("paper", "J_k"), ("panda", "J_d"))),
)


@dataclass(frozen=True)
class Config:
    """What is compared.

    Attributes:
        stages: By budget, the shortest first.
    """

    stages: tuple[Stage, ...] = STAGES

    @classmethod
    def smoke(cls) -> Config:
        """Small enough for a test."""
        cells: tuple[Cell, ...] = (("paper", "J_k"),)
        return cls((Stage(0.05, 3, cells=cells), Stage(0.2, 2, GRADIENT, cells)))

    @property
    def budgets(self) -> tuple[float, ...]:
        """At which runs are read [s]."""
        return tuple(stage.seconds for stage in self.stages)

    def cases(self) -> list[Case]:
        """Every run once, at the longest of its budgets; the short ones first, seed by seed."""
        longest = {
            (*cell, optimiser, seed): stage.seconds
            for stage in self.stages
            for seed in range(stage.seeds)
            for cell in stage.cells
            for optimiser in stage.optimisers
        }
        cases = [
            Case(*run, seconds, tuple(budget for budget in self.budgets if budget < seconds))
            for run, seconds in longest.items()
        ]
        return sorted(cases, key=lambda case: (case.seconds, case.seed))


def runner(out: Path) -> CaseRunner[Case]:
    """What works through the cases, with its lines in `out`/runs.csv."""
    return CaseRunner(run_case, RowFile(out / "runs.csv", KEY, VALUES), "optimiser runs")


def write(config: Config, rows: RowFile, out: Path) -> None:
    """Leave summary, figure and provenance beside the rows."""
    chosen = rows.rows_of(case.key for case in config.cases())
    write_summary(chosen, config.budgets, out)
    Provenance.collect(config, seed=None).write(out / "provenance.json")


@dataclass(frozen=True)
class Options(CaseOptions):
    """Which optimiser designs the best excitation in 1, 10 and 60 CPU seconds?

    Attributes:
        seeds: Runs of each optimiser at each budget, the shortest budget first.
    """

    study: ClassVar[str] = "compare_optimisers"
    names: ClassVar[tuple[str, ...]] = (
        "summary.md",
        "provenance.json",
        "gap.png",
        "gap.pdf",
    )

    seeds: tuple[Count, ...] = tuple(stage.seeds for stage in STAGES)

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.seeds) != len(STAGES):
            budgets = ", ".join(f"{stage.seconds:g}" for stage in STAGES)
            raise ValueError(
                f"--seeds {' '.join(map(str, self.seeds))}: give {len(STAGES)} numbers, "
                f"for {budgets} CPU seconds"
            )

    @property
    def config(self) -> Config:
        """What is compared."""
        if self.smoke:
            return Config.smoke()
        return Config(
            tuple(
                dataclasses.replace(stage, seeds=seeds)
                for stage, seeds in zip(STAGES, self.seeds, strict=True)
            )
        )


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
