"""Does the diagnosis tell the truth? A blind test on simulated arms.

    python -m studies.bench --out results/bench [--cases clean single …] [--seeds N] [--smoke]

A run that was interrupted goes on where it stopped. `--make` only makes the data sets.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from oed.commands.options import Count, Seed, parse
from oed.errors import OedError
from oed.report.bench_plots import (
    plot_confusion,
    plot_detection,
    plot_errors,
    plot_reliability,
)
from oed.report.json_file import write_atomically
from oed.report.progress import progress
from oed.report.provenance import Provenance
from oed.report.style import save_figure
from studies.bench.case import KEY_COLUMNS, Case
from studies.bench.judge import VALUE_COLUMNS, Judge
from studies.bench.plan import GROUPS, plan, smoke
from studies.bench.rates import BenchRow, done
from studies.bench.reliability import reliability
from studies.bench.summary import confusion, detection, page
from studies.case_runner import CaseRunner, RowFile, all_failed
from studies.study_options import CaseOptions

RUNS = "runs.csv"
NOTE = (
    "Simulated arms with effects that the data set does not mention, written without the "
    "catalogue's formulas; the diagnosis runs as a black box. Each data set: two estimation "
    "recordings, one for validation, one for the test; noise, colour, encoders and motion drawn."
)


@dataclass(frozen=True)
class Config:
    """What the bench does.

    Attributes:
        groups: Questions, of `GROUPS`.
        seeds: Rounds.
        first_seed: Seed of the first.
        module: The diagnosis.
        limit: Longest time for a diagnosis [s].
        options: Of the diagnosis.
    """

    groups: tuple[str, ...] = GROUPS
    seeds: int = 3
    first_seed: int = 0
    module: str = "studies.close_loop"
    limit: float = 900.0
    options: tuple[str, ...] = ()

    @classmethod
    def smoke(cls) -> Config:
        """Of a diagnosis that only shows that it works."""
        return cls(seeds=1, options=("--smoke", "--candidates", "torque_offset"))


def run(
    config: Config,
    cases: Sequence[Case],
    out: Path,
    folder: Path,
    *,
    workers: int = 1,
    scheduler: str | None = None,
) -> list[BenchRow]:
    """Do the cases that have no line yet, and return all lines."""
    rows = RowFile(out / RUNS, KEY_COLUMNS, VALUE_COLUMNS)
    judge = Judge(folder, config.module, config.limit, options=config.options)
    work = CaseRunner(judge, rows, "bench", code=(config.module,))
    work.run(cases, workers=workers, scheduler=scheduler)
    return list(rows.rows())


def make(cases: Sequence[Case], folder: Path) -> int:
    """Make the data sets and truths of cases that have none; say how many there are.

    An arm that runs away in simulation has none, and is said on the way.
    """
    judge, made = Judge(folder), 0
    for case in progress(cases, "data sets"):
        try:
            judge.prepare(case)
            made += 1
        except OedError as error:
            print(f"{case.label}: {error}", file=sys.stderr)
    return made


def write(rows: Sequence[BenchRow], config: Config, out: Path) -> None:
    """Save the summary, the figures and where they come from; the lines are there already."""
    out.mkdir(parents=True, exist_ok=True)
    write_atomically(out / "summary.md", page(rows, NOTE))
    Provenance.collect(config, seed=config.first_seed).write(out / "provenance.json")
    judged = done(rows)
    if not judged:
        return
    save_figure(plot_confusion(confusion(rows)), out / "confusion", ("png",))
    if names := reliability(rows):
        save_figure(plot_reliability(names), out / "reliability", ("png",))
    if curve := detection(rows):
        save_figure(plot_detection(curve), out / "detection", ("png",))
    groups = [g for g in GROUPS if any(row["group"] == g for row in judged)]
    ratios = [[float(r["after_to_floor"]) for r in judged if r["group"] == g] for g in groups]
    save_figure(plot_errors(groups, ratios), out / "errors", ("png",))


@dataclass(frozen=True)
class Options(CaseOptions):
    """How often is a diagnosis right, wrong or silent, on forms that its author has not seen?

    Attributes:
        cases: Groups of cases.
        seeds: Rounds.
        first_seed: Seed of the first round.
        folder: For the data sets.
        summarise: Only the lines that are there.
        make: Only make the data sets.
    """

    study: ClassVar[str] = "bench"
    names: ClassVar[tuple[str, ...]] = (
        "summary.md",
        "provenance.json",
        "confusion.png",
        "detection.png",
        "errors.png",
        "reliability.png",
    )

    cases: tuple[str, ...] = GROUPS
    seeds: Count = Config.seeds
    first_seed: Seed = 0
    folder: Path = Path("out/bench")
    summarise: bool = False
    make: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if unknown := set(self.cases) - set(GROUPS):
            raise ValueError(f"--cases {' '.join(sorted(unknown))}: there are {', '.join(GROUPS)}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 1 if all failed, else 0."""
    options = parse(Options, prog="python -m studies.bench", arguments=arguments)
    config = (
        Config.smoke()
        if options.smoke
        else Config(options.cases, options.seeds, options.first_seed)
    )
    cases = smoke() if options.smoke else plan(config.seeds, config.groups, first=config.first_seed)
    sets = options.folder
    if options.make:
        print(f"{make(cases, sets)} data sets in {sets / 'data'}")
        return 0
    todo = [] if options.summarise else cases
    out, workers = options.results, options.workers
    with options.held() as results:
        rows = run(config, todo, out, sets, workers=workers, scheduler=options.scheduler)
        with results.replaced() as new:
            write(rows, config, new)
    print(page(rows, NOTE))
    return int(all_failed(rows))
