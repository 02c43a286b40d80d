"""Does the diagnosis tell the truth? A blind test on simulated arms.

    python -m studies.bench --out results/bench [--cases clean single …] [--seeds N] [--smoke]

A run that was interrupted goes on where it stopped. `--make` only makes the data sets.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.errors import OedError
from oed.report.bench_plots import plot_confusion, plot_detection, plot_errors
from oed.report.json_file import write_atomically
from oed.report.output_folder import output_folder, results_folder
from oed.report.progress import progress
from oed.report.provenance import Provenance
from oed.report.style import save_figure
from studies.bench.case import KEY_COLUMNS, Case
from studies.bench.judge import VALUE_COLUMNS, Judge
from studies.bench.plan import GROUPS, plan, smoke
from studies.bench.rates import BenchRow, done
from studies.bench.summary import confusion, detection, page
from studies.case_runner import CaseRunner, RowFile
from studies.whole_numbers import from_one, from_zero

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
    """

    groups: tuple[str, ...] = GROUPS
    seeds: int = 3
    first_seed: int = 0
    module: str = "studies.close_loop"
    limit: float = 900.0


def run(
    config: Config, cases: Sequence[Case], out: Path, folder: Path, workers: int
) -> list[BenchRow]:
    """Do the cases that have no line yet, and return all lines."""
    rows = RowFile(out / RUNS, KEY_COLUMNS, VALUE_COLUMNS)
    judge = Judge(folder, config.module, config.limit)
    CaseRunner(judge, rows, "bench").run(cases, workers=workers)
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
    if curve := detection(rows):
        save_figure(plot_detection(curve), out / "detection", ("png",))
    groups = [g for g in GROUPS if any(row["group"] == g for row in judged)]
    ratios = [[float(r["after_to_floor"]) for r in judged if r["group"] == g] for g in groups]
    save_figure(plot_errors(groups, ratios), out / "errors", ("png",))


def main(arguments: Sequence[str] | None = None) -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m studies.bench", description="A blind test of the diagnosis."
    )
    parser.add_argument("--out", type=output_folder, help="results/bench if not given")
    parser.add_argument("--cases", nargs="+", choices=GROUPS, default=list(GROUPS))
    parser.add_argument("--seeds", type=from_one, default=Config.seeds, help="rounds")
    parser.add_argument("--first-seed", type=from_zero, default=0)
    parser.add_argument("--workers", type=from_one, default=1)
    parser.add_argument("--folder", type=Path, default=Path("out/bench"), help="for data sets")
    parser.add_argument("--smoke", action="store_true", help="two cases, to see that it works")
    parser.add_argument("--summarise", action="store_true", help="only the lines that are there")
    parser.add_argument("--make", action="store_true", help="only make the data sets")
    options = parser.parse_args(arguments)
    options.out = options.out or results_folder("bench", smoke=options.smoke)
    config = Config(tuple(options.cases), options.seeds, options.first_seed)
    cases = smoke() if options.smoke else plan(config.seeds, config.groups, first=config.first_seed)
    if options.make:
        print(f"{make(cases, options.folder)} data sets in {options.folder / 'data'}")
        return
    todo = [] if options.summarise else cases
    rows = run(config, todo, options.out, options.folder, options.workers)
    write(rows, config, options.out)
    print(page(rows, NOTE))
