"""`oed cross-check`: our torques against Drake's and Pinocchio's, on any robot file."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path

from oed.commands.configurations import CrossCheck
from oed.commands.telling import speak
from oed.dynamics.cross_check import AGREEMENT, cross_check
from oed.dynamics.identifiability import rigid_body_base_parameters
from oed.errors import OedError
from oed.report.progress import progress
from oed.report.provenance import Provenance
from oed.report.result_folder import ResultFiles
from oed.report.table import Row, markdown_table, text_table, write_csv
from oed.robot import Robot, load_arm

NAMES = ("runs.csv", "summary.md", "provenance.json")


def compare(sources: Sequence[str], states: int, seed: int) -> list[Row]:
    """One row a robot; a robot that cannot be compared is a row that says why.

    Args:
        sources: Files or built-in names.
        states: Random states a robot.
        seed: Of the states.

    Raises:
        RobotError: If a file cannot be used, before any is compared.
    """
    robots = [load_arm(source) for source in sources]
    rows: list[Row] = []
    for robot in progress(robots, "cross-check"):
        try:
            rows.append(_row(robot, states, seed))
        except OedError as error:
            rows.append({"robot": robot.name, "problem": str(error)})
    return rows


def write(rows: Sequence[Row], configuration: object, out: Path, states: int, seed: int) -> None:
    """Leave runs.csv, summary.md and provenance.json."""
    write_csv(out / "runs.csv", rows)
    notes = "".join(f"\n- {row['robot']}: {row['note']}" for row in rows if row.get("note"))
    text = (
        "# Cross-check against Drake\n\n"
        f"Worst disagreement with Drake over {states} random states, relative to the largest torque; "
        f"agreement means below {AGREEMENT:g}. Base parameters by the torque and by the energy "
        'model; "as written" is the numerical rank of the file\'s rounded kinematics.\n\n'
        f"{markdown_table(rows, columns=_columns(rows), digits=2)}\n{notes}\n"
    )
    (out / "summary.md").write_text(text, encoding="utf-8")
    Provenance.collect(configuration, seed=seed).write(out / "provenance.json")


def tell(rows: Sequence[Row]) -> int:
    """Print what was replaced, then what was found of it; 0 if all robots agree, 1 otherwise."""
    for row in rows:
        if row.get("note"):
            print(f"{row['robot']}: {row['note']}")
    print(text_table(rows, columns=_columns(rows), digits=2))
    return 0 if all(row.get("agrees") for row in rows) else 1


def run(config: CrossCheck) -> int:
    """Compare, print, and leave the table where a folder is named."""
    speak(quiet=config.quiet)
    files = ResultFiles("cross-check", NAMES)
    inputs = [robot for robot in config.robots if not robot.startswith("builtin:")]
    with nullcontext() if config.out is None else files.in_folder(config.out, inputs) as results:
        rows = compare(config.robots, config.states, config.seed)
        if results is not None:
            with results.replaced() as new:
                write(rows, config, new, config.states, config.seed)
    return tell(rows)


def _columns(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(name for row in rows for name in row if name != "note"))


def _row(robot: Robot, states: int, seed: int) -> Row:
    check = cross_check(robot, states=states, seed=seed)
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
