"""How do our models stand to the published ones, on recordings that anyone can fetch?

    python -m studies.public_arms --repo DIR [DIR …] [--data DIR] [--out results/public_arms]
                                  [--budget S] [--workers N] [--scheduler ADDRESS] [--smoke]

`--repo` names local clones, or folders that hold some; nothing is downloaded, and a recording whose clone is missing has a line
that says how to get it. `--data` adds data sets of your own, as a folder that holds one or several.
Whole diagnoses go to `--reports`. A run that was interrupted goes on where it stopped; a clone at
another commit, or a data set that has changed, is done again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from oed.commands.options import Folder, OutFolder, Seed, parse
from oed.report.input_files import data_digest
from oed.report.json_file import write_atomically
from oed.report.provenance import Provenance
from studies.case_runner import CaseRunner, RowFile, all_failed
from studies.data_folders import data_sets
from studies.public_arms.catalogue import ARMS
from studies.public_arms.clones import clone_of, commit_of
from studies.public_arms.judge import KEY, VALUES, Case, work
from studies.public_arms.summary import page
from studies.study_options import CaseOptions

SHORT = 12  # digits of a data set's hash
# CPU time of a search [s]: on the present arms longer ones find little more for a user's patience.
BUDGET, SMOKE_BUDGET = 60.0, 1.0


@dataclass(frozen=True)
class Config:
    """What is compared.

    Attributes:
        arms: Of the catalogue, each with the commit of its clone, empty where there is none.
        data_sets: Others, each with the hash of its content.
        budget: CPU time of each search [s].
        seed: Of everything random.
        smoke: Whether each is only a try.
    """

    arms: dict[str, str]
    data_sets: dict[str, str]
    budget: float
    seed: int
    smoke: bool


@dataclass(frozen=True)
class Options(CaseOptions):
    """How do our models stand to the published ones, on recordings that anyone can fetch?

    Attributes:
        repo: Local clones of the repositories, or folders that hold some.
        data: Folder of data sets besides. Results with it go to out/public_arms.
        arms: Names of the recordings; all if not given.
        reports: Folder for data sets and whole diagnoses.
        budget: CPU time of each search [s].
        seed: Of everything random.
    """

    study: ClassVar[str] = "public_arms"
    names: ClassVar[tuple[str, ...]] = ("summary.md", "provenance.json")

    repo: tuple[Path, ...] = ()
    data: Folder | None = None
    arms: tuple[str, ...] = ()
    reports: OutFolder = Path("out/public_arms/reports")
    budget: float = BUDGET
    seed: Seed = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        unknown = [name for name in self.arms if name not in ARMS]
        if unknown:
            raise ValueError(f"--arms: no recording {unknown[0]!r}; there are {', '.join(ARMS)}")
        if not self.budget >= 0:
            raise ValueError(f"--budget {self.budget:g} must not be negative: seconds of CPU time")

    @property
    def is_kept(self) -> bool:
        """Whether these are results of this project: of all public recordings, and no user's."""
        return super().is_kept and self.data is None and not self.arms


def cases_of(options: Options) -> list[Case]:
    """One a recording, whether its clone is there or not; then the data sets."""
    budget = SMOKE_BUDGET if options.smoke else options.budget
    found = []
    for name in options.arms or ARMS:
        clone = clone_of(ARMS[name].marker, options.repo)
        content = "" if clone is None else commit_of(clone)
        found.append((name, content, clone or Path()))
    sets = () if options.data is None else data_sets(options.data)
    found += [(folder.name, data_digest(folder)[:SHORT], folder) for folder in sets]
    return [
        Case(name, content, budget, options.seed, options.smoke, place, options.reports)
        for name, content, place in found
    ]


def config_of(cases: Sequence[Case], options: Options) -> Config:
    """What provenance says."""
    content = {case.arm: case.content for case in cases}
    public = {name: x for name, x in content.items() if name in ARMS}
    others = {name: x for name, x in content.items() if name not in ARMS}
    return Config(public, others, cases[0].budget, options.seed, options.smoke)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 1 if all failed, 2 if the input cannot be used, else 0."""
    options = parse(Options, prog="python -m studies.public_arms", arguments=arguments)
    cases = cases_of(options)
    inputs = [case.place for case in cases if case.content]
    with options.held(inputs) as results:
        rows = RowFile(options.results / "runs.csv", KEY, VALUES)
        runner = CaseRunner(work, rows, "public arms")
        runner.run(cases, workers=options.workers, scheduler=options.scheduler)
        lines = rows.rows_of(case.key for case in cases)
        with results.replaced() as new:
            write_atomically(new / "summary.md", page(lines))
            config = config_of(cases, options)
            Provenance.collect(config, seed=config.seed).write(new / "provenance.json")
    print(page(lines))
    return int(all_failed(lines))
