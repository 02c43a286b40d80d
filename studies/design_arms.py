"""Is the motion that comes out of the box safe for any arm, what does safety cost, how long?

    python -m studies.design_arms [--robot FILE ...] [--out results/design] [--smoke]

Runs `studies.design` on the arms of the package example-robot-data, each in a process of its own
as a user would, one after the other: with default settings, and with all that keeps an arm safe
switched off. Arms that this code has done already are not done again.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from oed.commands.options import parse
from oed.process_end import NO_USABLE_RESULT, ends_with_this, leave
from oed.report.code_digest import code_digest
from oed.report.folder_lock import STATE
from oed.report.json_file import write_atomically
from oed.report.progress import progress
from oed.report.provenance import Provenance
from oed.report.result_folder import ResultFiles
from oed.report.study_files import DESIGN
from oed.report.table import Cell, Row, markdown_table, number_of, read_csv, write_csv
from studies.data_folders import EXAMPLE_ARMS, EXAMPLE_ROBOTS, REPOSITORY
from studies.study_options import StudyOptions

ARMS = (
    *EXAMPLE_ARMS,
    "so_arm_description/urdf/so100.urdf",
    "asr_twodof_description/urdf/TwoDofs.urdf",
    "ur_description/urdf/ur3_gripper.urdf",
    "ur_description/urdf/ur5_gripper.urdf",
    "tiago_description/robots/tiago_dual.urdf",
    "tiago_pro_description/robots/tiago_pro.urdf",
    "anymal_b_simple_description/robots/anymal-kinova.urdf",
    "centauro_description/urdf/centauro.urdf",
    "pr2_description/urdf/pr2.urdf",
    "baxter_description/urdf/baxter.urdf",
)
FILES = ResultFiles("design_arms", ("runs.csv", "summary.md", "provenance.json"))
LONGEST = 900.0  # [s] after which an arm counts as failed
DIGITS = 16  # of the code's digest
UNSAFE = ("--periodic", "--margin", "1", "--no-clearance")


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


def run(config: Config, table: Path | None = None) -> list[Row]:
    """One row an arm; one that fails is a row that says why.

    Args:
        config: What to run.
        table: Where rows are kept after each arm; those that the same code left there are not
            made again. None to keep none.
    """
    robots = config.robots or tuple(str(EXAMPLE_ROBOTS / arm) for arm in ARMS)
    code = code_digest("studies.design")[:DIGITS]
    earlier = read_csv(table) if table is not None and table.is_file() else []
    done = {row["arm"]: row for row in earlier if row.get("code") == code and row.get("feasible")}
    rows: list[Row] = []
    for robot in progress(robots, "arms"):
        rows.append(done.get(Path(robot).stem) or {**_row(robot, config), "code": code})
        if table is not None:
            write_csv(table, rows)
    return rows


def _row(robot: str, config: Config) -> Row:
    with tempfile.TemporaryDirectory() as scratch:
        out, unsafe = Path(scratch) / "out", Path(scratch) / "unsafe"
        before, started = _children_cpu(), time.perf_counter()
        problem = _design(robot, out, smoke=config.smoke)
        wall, cpu = time.perf_counter() - started, _children_cpu() - before
        row: dict[str, Cell] = {
            "arm": Path(robot).stem,
            "wall_s": round(wall, 1),
            "cpu_s": round(cpu, 1),
        }
        if problem:
            return {**row, "problem": problem}
        row |= _found(_record(out))
        problem = _design(robot, unsafe, *UNSAFE, smoke=config.smoke)
        if problem:
            return {**row, "problem": f"without safety: {problem}"}
        return {**row, **_found_unsafe(_record(unsafe))}


def _record(out: Path) -> dict:
    return json.loads((out / "design.json").read_text(encoding="utf-8"))


def _design(robot: str, out: Path, *options: str, smoke: bool) -> str:
    """Run the design study; empty if it did its work, else the end of what it said."""
    # The study runs in the repository, not where the user's relative path starts.
    source = robot if robot.startswith("builtin:") else str(Path(robot).absolute())
    command = [sys.executable, "-m", "studies.design", "--robot", source, "--out", str(out)]
    command += options
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
    efficiency, before = record["d_efficiency"] or {}, record["before_clearance"] or {}
    standing = {limit["limit"]: limit["standing"] for limit in record["asked"]}
    return {
        "joints": len(record["joints"]),
        "base": len(record["base_parameters"]),
        "feasible": record["usable"],
        "violation": record["certified_violation"],
        "J_k": record["J_k"],
        "J_d": record["J_d_log10"],
        "J_k_not_clear": before.get("J_k", ""),
        "J_d_not_clear": before.get("J_d_log10", ""),
        "clear": standing.get("clear of itself", ""),
        "least_mm": _least(record),
        "d_efficiency": efficiency.get("value", ""),
        "kind": efficiency.get("kind", ""),
        "instants": record["instants"],
        "horizon_s": record["horizon"],
        "evaluations": record["evaluations"],
    }


def _found_unsafe(record: dict) -> Row:
    return {
        "J_k_unsafe": record["J_k"],
        "J_d_unsafe": record["J_d_log10"],
        "least_mm_unsafe": _least(record),
    }


def _least(record: dict) -> float | str:
    """Least distance of two links [mm]; empty where none comes near, or none is known."""
    bodies = record["clearance"]["bodies"] or {}
    least = bodies.get("least")
    return "" if least is None else round(1e3 * least, 2)


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
    clear = [row for row in good if row.get("clear") == "proven"]
    text = f"""\
# A motion for any arm, with default settings

`studies.design --robot FILE --out DIR`, one process an arm, one thread, the file and nothing else:
{len(good)} of {len(rows)} arms have a motion that is proven to keep its limits for all t, from rest to rest, and
a finite J_k; {len(clear)} of these are proven clear of themselves, for all t, by the default clearance. Of the
others some link has no collision shape, lacks its mesh, or overlaps another in nearly all postures, which
cannot be judged; what can be is proven. The longest took {max(walls):.1f} s of wall and {max(cpus):.1f} s of CPU time,
imports, compilation, bound, pictures and recording included. J_k = cond Lambda and
J_d = log10 det Lambda are without column scaling, R_v = I, at {_all(rows, "instants")} instants of a period of
{_all(rows, "horizon_s")} s, a row for each joint and instant. `..._not_clear` is the best motion found in the same run that
need not keep clear, `..._unsafe` that of another run with `{" ".join(UNSAFE)}`: what
safety costs. `least_mm` is the least distance of two links, negative where they overlap.
D-efficiency is against a bound on every periodic motion within the position, velocity and
acceleration limits, whatever its parametrisation: proven up to two joints, estimated beyond.

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
    "clear",
    "least_mm",
    "least_mm_unsafe",
    "J_k",
    "J_k_not_clear",
    "J_k_unsafe",
    "J_d",
    "J_d_not_clear",
    "J_d_unsafe",
    "d_efficiency",
    "kind",
    "wall_s",
    "cpu_s",
)


@dataclass(frozen=True)
class Options(StudyOptions):
    """Is the motion that comes out of the box safe for any arm, what does safety cost, how long?

    Attributes:
        robot: Files; the default list if none.
    """

    study: ClassVar[str] = "design"
    names: ClassVar[tuple[str, ...]] = FILES.names

    robot: tuple[str, ...] = ()


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    options = parse(Options, prog="python -m studies.design_arms", arguments=arguments)
    config = Config(options.robot, options.results, options.smoke)
    with options.held(config.robots) as results:
        rows = run(config, config.out / STATE / "arms.csv")
        with results.replaced() as new:
            write(rows, config, new)
    print((config.out / "summary.md").read_text(encoding="utf-8"))
    return 0


if __name__ == "__main__":
    leave(main, "studies.design_arms")
