"""Does a motion come out of the box for any arm, how good is it, and how long does it take?

    python -m studies.design_arms [--robot FILE ...] [--out results/design] [--smoke]

Runs `studies.design` with default settings on the arms of the package example-robot-data, each in
a process of its own as a user would, one after the other.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.process_end import ends_with_this
from oed.report.json_file import write_atomically
from oed.report.output_folder import output_folder, results_folder
from oed.report.progress import progress
from oed.report.provenance import Provenance
from oed.report.result_folder import ResultFiles
from oed.report.study_files import DESIGN
from oed.report.table import Row, markdown_table, number_of, write_csv
from studies.data_folders import EXAMPLE_ARMS, EXAMPLE_ROBOTS, REPOSITORY
from studies.interrupt import NO_USABLE_RESULT, leave

ARMS = (
    *EXAMPLE_ARMS,
    "so_arm_description/urdf/so100.urdf",
    "asr_twodof_description/urdf/TwoDofs.urdf",
)
FILES = ResultFiles("design_arms", ("runs.csv", "summary.md", "provenance.json"))
LONGEST = 300.0  # [s] after which an arm counts as failed


@dataclass(frozen=True)
class Config:
    """What to run.

    Attributes:
        robots: Files or built-in names; the default list if empty.
        out: Folder to leave results in.
        smoke: Whether each is to take a few seconds only.
    """

    robots: tuple[str, ...] = ()
    out: Path = Path("results/design")
    smoke: bool = False


def run(config: Config) -> list[Row]:
    """One row an arm; one that fails is a row that says why."""
    robots = config.robots or tuple(str(EXAMPLE_ROBOTS / arm) for arm in ARMS)
    return [_row(robot, config) for robot in progress(robots, "arms")]


def _row(robot: str, config: Config) -> Row:
    with tempfile.TemporaryDirectory() as scratch:
        out = Path(scratch) / "out"
        before, started = _children_cpu(), time.perf_counter()
        problem = _design(robot, out, smoke=config.smoke)
        wall, cpu = time.perf_counter() - started, _children_cpu() - before
        row: Row = {"arm": Path(robot).stem, "wall_s": round(wall, 1), "cpu_s": round(cpu, 1)}
        if problem:
            return {**row, "problem": problem}
        return {**row, **_found(json.loads((out / "design.json").read_text(encoding="utf-8")))}


def _design(robot: str, out: Path, *, smoke: bool) -> str:
    """Run the design study; empty if it did its work, else the end of what it said."""
    # The study runs in the repository, not where the user's relative path starts.
    source = robot if robot.startswith("builtin:") else str(Path(robot).absolute())
    command = [sys.executable, "-m", "studies.design", "--robot", source, "--out", str(out)]
    try:
        finished = subprocess.run(  # noqa: S603  # our own study
            [*command, *(["--smoke"] if smoke else [])],
            cwd=REPOSITORY,
            env={**ends_with_this(), "OMP_NUM_THREADS": "1"},
            timeout=LONGEST,
            capture_output=True,
            text=True,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"not done after {LONGEST:g} s"
    if finished.returncode == 0:
        return ""
    if finished.returncode == NO_USABLE_RESULT and DESIGN.are_in(out):
        return json.loads((out / DESIGN.names[0]).read_text(encoding="utf-8"))["status"]
    said = " ".join(finished.stderr.split())[-200:]
    return said or f"ended with code {finished.returncode} and said nothing"


def _found(record: dict) -> Row:
    efficiency, clearance = record["d_efficiency"] or {}, record["clearance"]
    return {
        "joints": len(record["joints"]),
        "base": len(record["base_parameters"]),
        "feasible": record["usable"],
        "violation": record["certified_violation"],
        "J_k": record["J_k"],
        "J_d": record["J_d_log10"],
        "J_d_continuous": record["J_d_log10_continuous"],
        "d_efficiency": efficiency.get("value", ""),
        "kind": efficiency.get("kind", ""),
        "instants": record["instants"],
        "horizon_s": record["horizon"],
        "evaluations": record["evaluations"],
        "least_distance_m": clearance["least"] if clearance["least"] is not None else "",
    }


def _children_cpu() -> float:
    """CPU time of the processes that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def write(rows: Sequence[Row], config: Config, out: Path | None = None) -> None:
    """Leave runs.csv, summary.md and provenance.json in a folder, the study's own if None."""
    out = config.out if out is None else out
    write_csv(out / "runs.csv", rows)
    good = [row for row in rows if row.get("feasible") is True and row.get("J_k") is not None]
    walls, cpus = ([number_of(row[key]) for row in rows] for key in ("wall_s", "cpu_s"))
    shown = [
        {key: row.get(key, "") for key in SHOWN} | {"problem": row.get("problem", "")}
        for row in rows
    ]
    if not any(row["problem"] for row in shown):
        shown = [{key: row[key] for key in SHOWN} for row in shown]
    text = f"""\
# A motion for any arm, with default settings

`studies.design --robot FILE --out DIR`, one process an arm, one thread, the file and nothing else:
{len(good)} of {len(rows)} arms have a motion that is proven to keep its limits for all t and a finite J_k.
The longest took {max(walls):.1f} s of wall and {max(cpus):.1f} s of CPU time, imports, compilation, bound, pictures and
recording included. J_k = cond Lambda and J_d = log10 det Lambda are without column scaling, R_v = I, at {_all(rows, "instants")}
instants of a period of {_all(rows, "horizon_s")} s, a row for each joint and instant. D-efficiency
is against a bound on every periodic motion within the position, velocity and acceleration limits,
whatever its parametrisation: proven up to two joints, estimated beyond. `least_distance_m` is that of two
bodies at the instants of a check, negative where they overlap: `--avoid-collision` was not asked for.

{markdown_table(shown)}"""
    write_atomically(out / "summary.md", text)
    Provenance.collect(config, seed=0).write(out / "provenance.json")


def _all(rows: Sequence[Row], key: str) -> str:
    """The values that occur in a column, such as "40 or 200"."""
    values = sorted({number_of(row[key]) for row in rows if key in row})
    return " or ".join(f"{value:g}" for value in values) or "no"


SHOWN = (
    "arm",
    "joints",
    "base",
    "feasible",
    "J_k",
    "J_d",
    "d_efficiency",
    "kind",
    "least_distance_m",
    "wall_s",
    "cpu_s",
)


def main(argv: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--robot", nargs="+", default=(), help="files; the default list if none")
    parser.add_argument("--out", type=output_folder, help="results/design if not given")
    parser.add_argument("--smoke", action="store_true", help="a few seconds an arm")
    given = parser.parse_args(argv)
    given.out = given.out or results_folder("design", smoke=given.smoke)
    config = Config(tuple(given.robot), given.out, given.smoke)
    with FILES.in_folder(config.out, config.robots) as results:
        rows = run(config)
        with results.replaced() as new:
            write(rows, config, new)
    print((config.out / "summary.md").read_text(encoding="utf-8"))
    return 0


if __name__ == "__main__":
    leave(main, "studies.design_arms")
