"""`oed import`: a data set of log files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from oed.commands.configurations import ImportLog
from oed.commands.telling import say, speak
from oed.experiment.dataset import DataSet
from oed.experiment.drive import TorqueKind
from oed.experiment.importing.import_log import ImportChoices, propose_import
from oed.experiment.importing.stated import stated_numbers, stated_words
from oed.experiment.importing.write_import import write_import
from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording import Role


def import_log(
    logs: str | Path | Sequence[str | Path],
    robot: str | Path,
    out: str | Path | None = None,
    *,
    joints: Sequence[str] = (),
    columns: Mapping[str, Sequence[str]] | None = None,
    units: Mapping[str, str | Sequence[str]] | None = None,
    sign: Sequence[float] = (),
    zero: Sequence[float] = (),
    ticks_per_turn: float | None = None,
    rate: float | None = None,
    fixed: Mapping[str, float] | None = None,
    torque: TorqueKind | None = None,
    current_to_torque: Sequence[float] = (),
    gravity: tuple[float, float, float] = ImportLog.gravity,
    roles: Sequence[Role] = (),
) -> DataSet:
    """Make a data set of log files: ROS bags, CSV, Parquet, .mat, .npz, HDF5.

    What is not given is concluded from the logs; the logger "oed" says what, and from what.

    Args:
        logs: One log file, or several of one format in the order in which they were recorded.
        robot: The robot's file, or "builtin:NAME".
        out: New folder for the data set, as `oed import` leaves it; none is written if None.
        joints: The robot's joints in the order of the log's columns.
        columns: Names of columns by quantity: t, q, dq, ddq, tau.
        units: Units by quantity, one or one a joint, such as {"q": "deg"}.
        sign: 1 or -1 a joint, where the log counts the other way.
        zero: Logged position of each joint where the robot's joint is at zero, in the log's unit.
        ticks_per_turn: Encoder ticks a turn, where positions are in ticks.
        rate: Rows a second, where no column tells the time [Hz].
        fixed: Position [rad or m] of each joint that stood still and is not logged, by name.
        torque: How the torque was obtained: "measured", "current" or "commanded".
        current_to_torque: Joint torque per motor current, gear included, one a joint [N m/A].
        gravity: In the robot's base frame [m/s^2].
        roles: "estimation", "validation" or "test", one a log; concluded if empty.

    Returns:
        The data set, in SI units.

    Raises:
        DataSetError: If a log cannot be read, or something about it cannot be concluded.
        RobotError: If the robot's file cannot be used.
        ValueError: If what is said contradicts itself, or the folder is in use.
    """
    files = (logs,) if isinstance(logs, (str, Path)) else tuple(logs)
    choices = ImportChoices(
        robot=str(robot),
        joints=tuple(joints),
        columns={key: _words(names) for key, names in (columns or {}).items()},
        units={key: _words(names) for key, names in (units or {}).items()},
        sign=tuple(map(float, sign)),
        zero=tuple(map(float, zero)),
        ticks_per_turn=ticks_per_turn,
        rate=rate,
        fixed=fixed,
        torque=torque,
        current_to_torque=tuple(map(float, current_to_torque)),
        gravity=gravity,
        roles=tuple(roles),
        name="" if out is not None else Path(files[0]).stem if files else "",
    )
    found = propose_import(files, choices, Path() if out is None else out)
    for note in found.notes:
        say(note)
    if out is None:
        return found.dataset
    write_import(found, out)
    return read_dataset(out)


def _words(given: str | Sequence[str]) -> tuple[str, ...]:
    return (given,) if isinstance(given, str) else tuple(given)


def import_into(config: ImportLog) -> tuple[str, ...]:
    """Read, conclude, check, write; returns what was concluded."""
    choices = ImportChoices(
        robot=config.robot,
        joints=config.joints,
        columns=stated_words("--columns", config.columns),
        units=stated_words("--units", config.units),
        sign=config.sign,
        zero=config.zero,
        ticks_per_turn=config.ticks_per_turn,
        rate=config.rate,
        fixed=stated_numbers("--fixed", config.fixed),
        torque=config.torque,
        current_to_torque=config.current_to_torque,
        gravity=config.gravity,
        roles=config.roles,
    )
    found = propose_import(config.logs, choices, config.out)
    write_import(found, config.out, reference=config.reference)
    return found.notes


def run(config: ImportLog) -> int:
    """Import, and say what was concluded."""
    speak(quiet=config.quiet)
    for note in import_into(config):
        say(f"  {note}")
    print(f"wrote {config.out}; read dataset.toml there and correct what is wrong")
    return 0
