"""From log files and a robot's file to a data set: proposed and checked, see `write_import`."""

from __future__ import annotations

import dataclasses
import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import tomli_w

from oed.counted import counted
from oed.errors import DataSetError
from oed.experiment.dataset import DataSet
from oed.experiment.drive import TorqueKind
from oed.experiment.importing.assign_joints import RobotJoints
from oed.experiment.importing.propose_columns import ColumnProposal, propose_columns
from oed.experiment.importing.propose_roles import Part, Timed, parts_of, propose_roles
from oed.experiment.importing.propose_units import UnitProposal
from oed.experiment.importing.rarely_logged import without_rarely_logged
from oed.experiment.importing.read_log_values import LogValues, read_values
from oed.experiment.importing.stated import OPTIONS, check_keys
from oed.experiment.importing.unused_columns import unused_note
from oed.experiment.log_format import COLUMN_KEYS, UNIT_KEYS
from oed.experiment.logs import MOST_HELD, Log, held, read_log
from oed.experiment.manifest import MANIFEST, manifest_of
from oed.experiment.read_dataset import dataset_of
from oed.experiment.recording import Role
from oed.experiment.toml_table import TomlTable
from oed.robot import Robot, arm_joints, load_robot


@dataclass(frozen=True)
class ImportChoices:
    """What the user says of the logs; all that is left out is proposed.

    Attributes:
        robot: The robot's file, or "builtin:NAME".
        joints: The joints of the robot that the logs are of, in the order of their columns.
        columns: Names of columns by quantity (t, q, dq, ddq, tau).
        units: Units by quantity.
        sign: (n,) 1 or -1 a joint, for all that is logged of it; or by quantity.
        zero: (n,) what is logged where the robot's joint is at zero, in the unit of the log.
        ticks_per_turn: Of encoders whose positions are in ticks.
        rate: Rows a second, where no column tells the time [Hz].
        fixed: Where joints stood that the logs lack [rad or m], by name; 0 if not given.
        torque: How the torque was obtained.
        current_to_torque: (n,) joint torque per motor current, gear included [N m/A].
        gravity: In the base frame [m/s^2].
        roles: One a log.
        reference: Whether logs stay where they are, instead of being copied.
        name: Of the data set; that of its folder if empty.
    """

    robot: str
    joints: tuple[str, ...] = ()
    columns: Mapping[str, tuple[str, ...]] | None = None
    units: Mapping[str, tuple[str, ...]] | None = None
    sign: tuple[float, ...] | Mapping[str, tuple[float, ...]] = ()
    zero: tuple[float, ...] = ()
    ticks_per_turn: float | None = None
    rate: float | None = None
    fixed: Mapping[str, float] | None = None
    torque: TorqueKind | None = None
    current_to_torque: tuple[float, ...] = ()
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    roles: tuple[Role, ...] = ()
    reference: bool = False
    name: str = ""


@dataclass(frozen=True)
class Import:
    """A data set that was read from logs and is not written yet.

    Attributes:
        dataset: As it will be read.
        content: Of its `dataset.toml`, with the logs where they are now.
        logs: The log files.
        notes: What was concluded, and from what, a line each.
    """

    dataset: DataSet
    content: Mapping[str, object]
    logs: tuple[Path, ...]
    notes: tuple[str, ...]


def propose_import(
    logs: Sequence[str | Path],
    choices: ImportChoices,
    out: str | Path,
    *,
    joints: Sequence[str] = (),
) -> Import:
    """Read logs and conclude what they are; nothing is written.

    Args:
        logs: Files of one format, in the order in which they were recorded.
        choices: What is known of them.
        out: Folder that the data set will have, for its name and for messages.
        joints: Of the data set that is returned, as of `read_dataset`; all if empty. What is to be
            written has all.

    Raises:
        DataSetError: If a log cannot be read, or something about it cannot be concluded.
        RobotError: If the robot's file cannot be read.
        ValueError: If there is no log, or one is given twice.
    """
    paths = tuple(Path(log) for log in logs)
    if not paths or len({path.resolve() for path in paths}) < len(paths):
        raise ValueError("give at least one log, and each once")
    if choices.roles and len(choices.roles) != len(paths):
        raise ValueError(
            f"{counted(len(choices.roles), 'role')} for {counted(len(paths), 'log')}; give one for each"
        )
    check_keys("--columns", choices.columns, COLUMN_KEYS)
    check_keys("--units", choices.units, UNIT_KEYS)
    columns = _columns(paths, choices)
    robot = load_robot(
        choices.robot, joints=columns[0].joints, locked=choices.fixed or {}, gravity=choices.gravity
    )
    values = read_values(columns, robot, choices.units or {}, choices.rate, choices.ticks_per_turn)
    parts, why = _roles(paths, values, choices)
    name = choices.name or Path(out).resolve().name
    content = _content(paths, choices, robot, values[0], parts) | {"name": name}
    opened = {path.resolve(): one.columns.log for path, one in zip(paths, values, strict=True)}
    dataset = _read(content, Path(out), tuple(joints) or None, opened)
    dead = [note for one in values for note in one.left_out]
    passed = unused_note([one.columns for one in values])
    first = (*columns[0].notes, *passed, *values[0].notes)
    notes = (*first, *_fixed_notes(robot), *dataset.notes, *dead, why)
    return Import(dataset, content, paths, tuple(dict.fromkeys(notes)))


def _columns(paths: Sequence[Path], choices: ImportChoices) -> list[ColumnProposal]:
    """The columns of each log, which must be the same."""
    joints = RobotJoints(
        load_robot(choices.robot).joint_names, arm_joints(choices.robot), choices.joints
    )
    for name in joints.chosen:
        if name not in joints.movable:
            raise ValueError(
                f"--joints: the robot has no joint {name!r}; it has {', '.join(joints.movable)}"
            )
    stated = dict(choices.columns or {})
    # What is concluded from a log and the recordings cut from it come of one reading.
    logs = (held(read_log(path), MOST_HELD // len(paths)) for path in paths)
    found = [propose_columns(log, joints, stated) for log in logs]
    for path, other in zip(paths, found, strict=True):
        if (other.columns, other.joints) != (found[0].columns, found[0].joints):
            message = (
                f"its columns are not those of {paths[0]}; import logs of one format at a time"
            )
            raise DataSetError(message, file=str(path))
    return without_rarely_logged(found, tuple(stated), timed=choices.rate is None)


def _roles(
    paths: Sequence[Path], values: Sequence[LogValues], choices: ImportChoices
) -> tuple[tuple[Part, ...], str]:
    logs = [
        Timed(path.stem, one.t, one.q, one.episode) for path, one in zip(paths, values, strict=True)
    ]
    parts, why = (
        (parts_of(logs, choices.roles), "roles: as given") if choices.roles else propose_roles(logs)
    )
    return tuple(_of_log(part, values[part.log]) for part in parts), why


def _of_log(part: Part, log: LogValues) -> Part:
    """A part of the rows that were read as one of all rows of the log."""
    first, last = part.rows or (0, len(log.rows))
    rows = int(log.rows[first]), int(log.rows[last - 1]) + 1
    is_all = part.rows is None and rows == (0, log.logged)
    return part if is_all else dataclasses.replace(part, rows=rows)


def _content(
    paths: Sequence[Path],
    choices: ImportChoices,
    robot: Robot,
    first: LogValues,
    parts: Sequence[Part],
) -> dict[str, object]:
    zero = list(choices.zero) or ([] if first.units.zero is None else first.units.zero.tolist())
    content: dict[str, object] = {
        "format": 1,
        "name": "",
        "source": f"imported from {', '.join(path.name for path in paths)}",
        "licence": "not stated",
        "robot": _robot_now(robot),
        "joints": list(robot.joint_names),
        "gravity": list(choices.gravity),
        "torque": choices.torque or first.columns.torque,
    }
    if choices.rate is not None:
        content["rate"] = choices.rate
    if choices.sign:
        own = choices.sign
        content["sign"] = dict(own) if isinstance(own, Mapping) else list(own)
    if zero:
        content["zero"] = zero
    content["columns"] = {
        key: names[0] if key in ("t", "repetition") else list(names)
        for key, names in first.columns.columns.items()
        if not (key == "t" and choices.rate is not None)
    }
    units = _units_table(first.units, robot.n)
    if units:
        content["units"] = units
    if choices.current_to_torque:
        content["drive"] = {"current_to_torque": list(choices.current_to_torque)}
    if robot.locked:
        content["fixed"] = robot.held
    content["recording"] = [_entry(paths, part, parts) for part in parts]
    return content


def _units_table(proposal: UnitProposal, joints: int) -> dict[str, object]:
    table: dict[str, object] = {
        key: units[0] if len(units) < joints or len(set(units)) == 1 else list(units)
        for key, units in proposal.units.items()
    }
    if proposal.ticks_per_turn is not None:
        table["ticks_per_turn"] = proposal.ticks_per_turn
    return table


def _entry(paths: Sequence[Path], part: Part, parts: Sequence[Part]) -> dict[str, object]:
    path = paths[part.log]
    is_cut = sum(other.log == part.log for other in parts) > 1
    stems = [other.stem for other in paths]
    stem = path.stem if stems.count(path.stem) == 1 else f"{path.stem}-{part.log + 1}"
    name = part.role if is_cut and len(paths) == 1 else f"{stem}-{part.role}" if is_cut else stem
    alike = [other for other in parts if (other.log, other.role) == (part.log, part.role)]
    if len(alike) > 1:
        name = f"{name}-{alike.index(part) + 1}"
    entry: dict[str, object] = {"file": str(path.resolve()), "name": name, "role": part.role}
    if part.rows is not None:
        entry["rows"] = [part.rows[0] + 1, part.rows[1]]
    if part.repetitions is not None:
        entry |= {"repetitions": part.repetitions, "period": part.period}
    return entry


def _robot_now(robot: Robot) -> str:
    source = robot.source
    return source if source.startswith("builtin:") else os.path.abspath(source)  # noqa: PTH100  keeps xacro arguments


def _read(
    content: Mapping[str, object],
    out: Path,
    joints: tuple[str, ...] | None,
    logs: Mapping[Path, Log],
) -> DataSet:
    # Through the text: what is written is what was read.
    parsed = tomllib.loads(tomli_w.dumps(content))
    path = out / MANIFEST
    try:
        return dataset_of(manifest_of(TomlTable(parsed, path)), out, joints=joints, logs=logs)
    except DataSetError as error:
        if error.file != str(path) or error.column not in OPTIONS:
            raise
        # There is no such file yet: an option said it.
        raise ValueError(f"{OPTIONS[error.column]}: {error.message}") from error


def _fixed_notes(robot: Robot) -> tuple[str, ...]:
    if not robot.locked:
        return ()
    held = ", ".join(f"{name} = {value:g}" for name, value in robot.held.items())
    return (f"fixed: the logs lack {held}; correct [fixed] if they stood elsewhere",)
