"""What do measured arms lack, and what does adding it gain on recordings that were not fitted?

    python -m studies.measured [--data DIR] [--out results/measured] [--reports DIR] [--seed N]
                               [--smoke]

Runs `studies.close_loop` on every data set in a folder, `../shared/data` by default, and sets what
it says of each side by side: verdict, names, errors before and after. The whole diagnosis of each
goes to `out/measured` or the folder given by `--reports`. A run that was interrupted goes on where
it stopped; a data set that has changed since, or whose diagnosis has, is done again.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from oed.commands.configurations import Diagnose
from oed.commands.diagnose import diagnose_into
from oed.commands.options import Folder, OutFolder, Seed, parse
from oed.diagnosis.diagnose import Diagnosis
from oed.diagnosis.inference.errors import RoleErrors
from oed.process_end import RESUMES, leave
from oed.report.joint_words import over_floor, place_words
from oed.report.json_file import write_atomically
from oed.report.provenance import Provenance
from oed.report.result_folder import ResultFiles, ResultFolder
from oed.report.table import MISSING, Row, markdown_table
from studies.case_runner import CaseRunner, RowFile, all_failed, is_finished
from studies.data_folders import SHARED, data_sets
from studies.study_options import StudyOptions

RUNS = "runs.csv"
FILES = ResultFiles("measured", ("summary.md", "provenance.json"))
KEY = ("data", "seed", "smoke")
UNSEEN = ("validation", "test")
EXPLAINED = (
    "Errors before and after, root mean square over the joints in noise floors: the base model "
    "(rigid body, Coulomb and viscous friction; rotor inertias where the data set declares them) "
    "and the same with what was found. The test recordings had no say; what they contradict is said. "
    "“Worst joint” is the largest ratio of after to before."
)
VALUES = (
    "status",
    "samples",
    "joints",
    "verdict",
    "named",
    "unnamed",
    *(f"{role}_{when}" for role in UNSEEN for when in ("before", "after", "worst_joint")),
    "contradicted",
    "relative_test",
    "seconds",
)


@dataclass(frozen=True)
class Config:
    """What is diagnosed.

    Attributes:
        data_sets: Names of their folders.
        seed: Of every diagnosis.
        smoke: Whether each is a small one.
    """

    data_sets: tuple[str, ...]
    seed: int
    smoke: bool


@dataclass(frozen=True)
class Case:
    """One data set.

    Attributes:
        folder: Of the data set.
        seed: Of the diagnosis.
        smoke: Whether it is a small one.
        reports: Folder for the diagnoses.
    """

    folder: Path
    seed: int
    smoke: bool
    reports: Path

    @property
    def kept(self) -> Path:
        """Where its diagnosis goes."""
        return self.reports / self.folder.name / f"seed_{self.seed}"

    @property
    def key(self) -> tuple[str, ...]:
        """As text, in the order of `KEY`."""
        return (self.folder.name, str(self.seed), "yes" if self.smoke else "no")


def work(case: Case) -> dict[str, str | int | float]:
    """A line of the table: what a diagnosis says of a data set."""
    start = time.perf_counter()
    outcome = diagnose_into(
        Diagnose(data=case.folder, out=case.kept, smoke=case.smoke, seed=case.seed)
    )
    found, dataset = outcome.found, outcome.dataset
    return {
        "status": "done",
        "samples": sum(len(r.t) for r in dataset.recordings),
        "joints": dataset.robot.n,
        "verdict": found.verdict,
        "named": "; ".join(f"{e.name} ({place_words(e.joint)})" for e in found.effects),
        "unnamed": "; ".join(f"{u.label} ({place_words(u.joint)})" for u in found.unexplained),
        "contradicted": "; ".join(found.contradicted),
        **{k: v for errors in found.errors for k, v in _errors(errors, found).items()},
        "seconds": round(time.perf_counter() - start),
    }


def _errors(errors: RoleErrors, found: Diagnosis) -> dict[str, str | float]:
    if errors.role not in UNSEEN:
        return {}
    before, after = (over_floor(x, found.noise_floor) for x in (errors.before, errors.after))
    told: dict[str, str | float] = {
        f"{errors.role}_before": round(before, 3),
        f"{errors.role}_after": round(after, 3),
        f"{errors.role}_worst_joint": round(float((errors.after / errors.before).max()), 3),
    }
    if errors.role == "test":
        pairs = zip(errors.before / errors.torque, errors.after / errors.torque, strict=True)
        told["relative_test"] = "; ".join(f"{old:.3f} → {new:.3f}" for old, new in pairs)
    return told


def page(rows: Sequence[Mapping[str, str]]) -> str:
    """The summary of the lines."""
    done = [row for row in rows if row["status"] == "done"]
    table: list[Row] = [
        {
            "data set": row["data"],
            "joints": row["joints"],
            "samples": row["samples"],
            **{role: _change(row[f"{role}_before"], row[f"{role}_after"]) for role in UNSEEN},
            "test, worst joint": row["test_worst_joint"] or MISSING,
            "verdict": row["verdict"],
            "seconds": row["seconds"],
        }
        for row in done
    ]
    parts = ["# Measured arms", EXPLAINED, *([markdown_table(table)] if table else [])]
    for row in done:
        parts += [
            f"## {row['data']}",
            f"Named: {row['named'] or 'nothing'}.",
            f"Without a name: {row['unnamed'] or 'nothing'}.",
            *([f"{row['contradicted']}."] if row["contradicted"] else []),
            "Test error over the torque's root mean square, joint by joint: "
            + (row["relative_test"] or MISSING),
        ]
    failed = [f"{row['data']}: {row['status']}" for row in rows if row["status"] != "done"]
    if failed:
        parts += ["## Not diagnosed", *failed]
    return "\n\n".join(parts) + "\n"


def _change(before: str, after: str) -> str:
    return f"{before} → {after}" if before else MISSING


def run(cases: Sequence[Case], config: Config, results: ResultFolder) -> list[dict[str, str]]:
    """Do the data sets that have no line yet, write the summary of all, return their lines."""
    rows = RowFile(results.folder / RUNS, KEY, VALUES)
    runner = CaseRunner(work, rows, "measured arms", data=lambda case: case.folder)
    finished = is_finished(rows, cases, config, runner.digest)
    # One after another: each works on all processors, as its user's would.
    runner.run(cases)
    lines = rows.rows_of(case.key for case in cases)
    if not finished:
        with results.replaced() as new:
            write_atomically(new / "summary.md", page(lines))
            Provenance.collect(config, seed=config.seed).write(new / "provenance.json")
    return lines


@dataclass(frozen=True)
class Options(StudyOptions):
    """What does a diagnosis say of measured arms, side by side?

    Attributes:
        data: Folder of data sets; ../shared/data if not given. Results on it go to out/measured.
        reports: Folder for whole diagnoses.
        seed: Of every diagnosis.
    """

    study: ClassVar[str] = "measured"
    names: ClassVar[tuple[str, ...]] = FILES.names

    data: Folder | None = None
    reports: OutFolder = Path("out/measured")
    seed: Seed = 0

    @property
    def is_kept(self) -> bool:
        """Whether these are results of this project: not of a user's data."""
        return super().is_kept and self.data is None


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 1 if all failed, 2 if the input cannot be used, else 0."""
    options = parse(Options, prog="python -m studies.measured", arguments=arguments)
    folders = data_sets(options.data)
    if not folders:
        raise ValueError(f"{SHARED}: no data sets; name a folder with --data")
    config = Config(tuple(f.name for f in folders), options.seed, options.smoke)
    cases = [Case(folder, options.seed, options.smoke, options.reports) for folder in folders]
    with options.held(folders) as results:
        lines = run(cases, config, results)
    print(page(lines))
    return int(all_failed(lines))


if __name__ == "__main__":
    leave(main, "studies.measured", RESUMES)
