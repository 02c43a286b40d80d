"""Does this package compute the torque that Drake and Pinocchio compute? And how many base parameters?

    python -m studies.cross_check [--robot FILE …] [--out DIR] [--smoke]

Without --robot: the paper's SCARA and the arms of the package example-robot-data.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.dynamics.cross_check import AGREEMENT, cross_check
from oed.dynamics.identifiability import rigid_body_base_parameters
from oed.errors import OedError
from oed.report.json_file import write_atomically
from oed.report.output_folder import output_folder, results_folder
from oed.report.progress import progress
from oed.report.provenance import Provenance
from oed.report.result_folder import ResultFiles
from oed.report.table import Row, markdown_table, text_table, write_csv
from oed.robot import load_arm
from studies.data_folders import EXAMPLE_ARMS, EXAMPLE_ROBOTS
from studies.interrupt import leave
from studies.whole_numbers import from_zero

FILES = ResultFiles("cross_check", ("runs.csv", "summary.md", "provenance.json"))


@dataclass(frozen=True)
class Config:
    """What to compare.

    Attributes:
        robots: Files or built-in names; the default list if empty.
        out: Folder to leave results in.
        states: Random states a robot.
        seed: Of the states.
    """

    robots: tuple[str, ...] = ()
    out: Path = Path("results/cross_check")
    states: int = 1000
    seed: int = 0


def run(config: Config) -> list[Row]:
    """One row a robot; a robot that cannot be compared is a row that says why."""
    robots = config.robots or (
        "builtin:imi_scara",
        *(str(EXAMPLE_ROBOTS / arm) for arm in EXAMPLE_ARMS),
    )
    rows = []
    for source in progress(robots, "cross-check"):
        try:
            rows.append(_row(source, config))
        except OedError as error:
            rows.append({"robot": Path(source).stem, "problem": str(error)})
    return rows


def write(rows: Sequence[Row], config: Config, out: Path) -> None:
    """Leave runs.csv, summary.md and provenance.json."""
    write_csv(out / "runs.csv", rows)
    columns = [name for name in rows[0] if name != "note"]
    notes = "".join(f"\n- {row['robot']}: {row['note']}" for row in rows if row.get("note"))
    text = (
        "# Cross-check against Drake\n\n"
        f"Worst disagreement with Drake over {config.states} random states, relative to the largest torque; "
        f"agreement means below {AGREEMENT:g}. Base parameters by the torque and by the energy "
        'model; "as written" is the numerical rank of the file\'s rounded kinematics.\n\n'
        f"{markdown_table(rows, columns=columns, digits=2)}\n{notes}\n"
    )
    write_atomically(out / "summary.md", text)
    Provenance.collect(config, seed=config.seed).write(out / "provenance.json")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 0 if all robots agree, 1 otherwise."""
    config = _parse(arguments)
    with FILES.in_folder(config.out, config.robots) as results:
        rows = run(config)
        with results.replaced() as new:
            write(rows, config, new)
    # What was replaced comes before what was found of it.
    for row in rows:
        if row.get("note"):
            sys.stdout.write(f"{row['robot']}: {row['note']}\n")
    columns = dict.fromkeys(name for row in rows for name in row if name != "note")
    sys.stdout.write(text_table(rows, columns=list(columns), digits=2) + "\n")
    return 0 if all(row.get("agrees") for row in rows) else 1


def _row(source: str, config: Config) -> Row:
    robot = load_arm(source)
    check = cross_check(robot, states=config.states, seed=config.seed)
    torque, energy = (rigid_body_base_parameters(robot, route=r) for r in ("torque", "energy"))
    as_written = (torque.singular_values > 1e-8 * torque.singular_values[0]).sum()
    return {
        "robot": robot.name,
        "joints": robot.n,
        "newton_euler": check.newton_euler,
        "regressor": check.regressor,
        "casadi": check.casadi,
        "pinocchio": check.pinocchio,
        "agrees": check.agrees,
        "base_torque": len(torque),
        "base_energy": len(energy),
        "as_written": int(as_written),
        "note": "; ".join(filter(None, (*robot.notes, torque.note))),
    }


def _parse(arguments: Sequence[str] | None) -> Config:
    parser = argparse.ArgumentParser(prog="python -m studies.cross_check", description=__doc__)
    parser.add_argument("--robot", nargs="+", default=(), help="robot files")
    parser.add_argument(
        "--out",
        type=output_folder,
        help="results/cross_check if not given, out/cross_check with --robot",
    )
    parser.add_argument("--seed", type=from_zero, default=Config.seed)
    parser.add_argument("--smoke", action="store_true", help="few states, first robots only")
    given = parser.parse_args(arguments)
    robots = tuple(given.robot)
    # The results that are kept are of the default list: a robot of one's own must not replace them.
    only_trying = given.smoke or bool(robots)
    given.out = given.out or results_folder("cross_check", smoke=only_trying)
    if given.smoke and not robots:
        robots = ("builtin:imi_scara", str(EXAMPLE_ROBOTS / EXAMPLE_ARMS[1]))
    states = 50 if given.smoke else Config.states
    return Config(robots=robots, out=given.out, states=states, seed=given.seed)


if __name__ == "__main__":
    leave(main, "studies.cross_check")
