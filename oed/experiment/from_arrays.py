"""Recordings from arrays at hand, with the checks that a file goes through."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from jaxtyping import Int
from numpy import ndarray

from oed.counted import counted
from oed.experiment.column_names import find_columns, joint_columns
from oed.experiment.drive import Drive, TorqueKind
from oed.experiment.importing.assign_joints import RobotJoints
from oed.experiment.importing.propose_columns import propose_columns
from oed.experiment.importing.propose_roles import Part, Timed, parts_of, propose_roles
from oed.experiment.log_format import LogFormat
from oed.experiment.logs.stamps import seconds_of_day
from oed.experiment.logs.table import Log, Table, table_of
from oed.experiment.manifest import RecordingEntry
from oed.experiment.read_recording import read_recording, take_samples
from oed.experiment.recording import Recording, Role
from oed.experiment.recording_checks import check_signals
from oed.robot import Robot

Arrays = ndarray | Sequence[ndarray]


@dataclass(frozen=True)
class About:
    """What a data set says of itself beside its numbers.

    Attributes:
        name: Shown in reports.
        torque: How it was obtained.
        drive: What is known of the drives.
    """

    name: str
    torque: TorqueKind
    drive: Drive


def recordings_from_arrays(
    robot: Robot, given: Mapping[str, Arrays | None], roles: Sequence[Role] | None, about: About
) -> tuple[Recording, ...]:
    """Of `DataSet.from_arrays`; `given` maps t, q, tau, dq and ddq to their arrays."""
    name = about.name
    listed = {key: _as_list(value) for key, value in given.items() if value is not None}
    counts = {key: len(values) for key, values in listed.items()}
    if len(set(counts.values())) > 1:
        raise ValueError(f"numbers of recordings disagree: {counts}")
    tables = []
    for i in range(counts["t"]):
        arrays = {key: np.asarray(values[i], dtype=float) for key, values in listed.items()}
        _check_shapes(arrays, robot, i)
        columns = {"t": arrays["t"]}
        for key in arrays.keys() - {"t"}:
            names = joint_columns(key, robot.n)
            columns |= dict(zip(names, arrays[key].T, strict=True))
        tables.append(table_of(columns, name if counts["t"] == 1 else f"{name}[{i}]"))
    return _recordings(robot, tables, LogFormat(), roles, about)


def recordings_from_frame(
    robot: Robot,
    frame: pd.DataFrame | Sequence[pd.DataFrame],
    *,
    roles: Sequence[Role] | None,
    log_format: LogFormat | None,
    name: str,
    torque: TorqueKind | None,
    drive: Drive,
) -> tuple[TorqueKind, tuple[Recording, ...]]:
    """Of `DataSet.from_frame`, and how the torque was obtained."""
    frames = [frame] if isinstance(frame, pd.DataFrame) else list(frame)
    if not frames:
        raise ValueError("give at least one frame")
    tables = []
    for i, one in enumerate(frames):
        arrays = _arrays(one)
        tables.append(table_of(arrays, name if len(frames) == 1 else f"{name}[{i}]"))
    joints = RobotJoints(robot.joint_names, robot.joint_names)
    stated = dict(log_format.columns) if log_format else {}
    found = propose_columns(Log(name, tuple(tables[:1])), joints, stated)
    chosen = log_format or LogFormat(columns=found.columns, units=found.units)
    if "t" not in found.columns and chosen.rate is None:
        raise ValueError(
            f"{name}: no column of time among {', '.join(tables[0].columns[:12])}; name it in "
            "log_format, or give its rate"
        )
    kind = torque or found.torque
    return kind, _recordings(robot, tables, chosen, roles, About(name, kind, drive))


def _recordings(
    robot: Robot,
    tables: Sequence[Table],
    log_format: LogFormat,
    roles: Sequence[Role] | None,
    about: About,
) -> tuple[Recording, ...]:
    """Tables with roles as given, or as proposed from their structure."""
    logs = [Log(table.file, (table,)) for table in tables]
    lines, timed = [], []
    for i, log in enumerate(logs):
        names = find_columns(log, robot, log_format)
        samples = take_samples(names, _entry(i, "estimation"), robot, log_format)
        lines.append(samples.lines)
        timed.append(Timed(str(i), samples.t, samples.joints["q"]))
    if roles is None:
        parts, why = propose_roles(timed)
    else:
        if len(roles) != len(tables):
            raise ValueError(
                f"{counted(len(roles), 'role')} for {counted(len(tables), 'recording')}; give one for each"
            )
        parts, why = parts_of(timed, roles), ""
    recordings = []
    is_cut = len({part.role for part in parts}) == len(parts) > len(logs)
    for i, part in enumerate(parts):
        entry = _entry(i, part.role, part, lines[part.log], is_cut=is_cut)
        recording = read_recording(
            logs[part.log], entry, robot, log_format, drive=about.drive, torque=about.torque
        )
        check_signals(recording.q, recording.tau, recording.source, robot)
        recordings.append(recording)
    if why:
        first = recordings[0]
        recordings[0] = dataclasses.replace(first, notes=(f"{about.name}: {why}", *first.notes))
    return tuple(recordings)


def _arrays(frame: pd.DataFrame) -> dict[str, ndarray]:
    """Columns of numbers, and of times as seconds; the index too where it has a name or is time."""
    if "t" not in frame.columns and isinstance(frame.index, pd.DatetimeIndex | pd.TimedeltaIndex):
        frame = frame.rename_axis(index=frame.index.name or "t")
    if "t" not in frame.columns and frame.index.name:
        frame = frame.reset_index()
    found: dict[str, ndarray] = {}
    for key, column in frame.items():
        if isinstance(column.dtype, pd.DatetimeTZDtype) or column.dtype.kind == "M":
            stamps = column.dt.as_unit("ns").astype(np.int64)
            found[str(key)] = seconds_of_day(stamps.to_numpy())
        elif column.dtype.kind == "m":
            found[str(key)] = column.dt.total_seconds().to_numpy()
        elif pd.api.types.is_numeric_dtype(column.dtype):
            found[str(key)] = column.to_numpy()
    return found


def _entry(
    index: int,
    role: Role,
    part: Part | None = None,
    lines: Int[ndarray, " samples"] | None = None,
    *,
    is_cut: bool = False,
) -> RecordingEntry:
    rows = None
    if part is not None and part.rows is not None and lines is not None:
        rows = int(lines[part.rows[0]]), int(lines[part.rows[1] - 1])
    name = role if is_cut else f"{index + 1}-{role}"
    repetitions = None if part is None else part.repetitions
    period = None if part is None else part.period
    return RecordingEntry("", name, role, repetitions, period, rows)


def _as_list(value: Arrays) -> list[ndarray]:
    """One array a recording."""
    if isinstance(value, ndarray):
        return [value]
    # A plain list of numbers is one recording too.
    items = [np.asarray(item, dtype=float) for item in value]
    if items and items[0].ndim == 0:
        return [np.asarray(value, dtype=float)]
    return items


def _check_shapes(arrays: Mapping[str, ndarray], robot: Robot, index: int) -> None:
    count = len(arrays["t"]) if arrays["t"].ndim == 1 else -1
    for key, array in arrays.items():
        expected = (count,) if key == "t" else (count, robot.n)
        if array.shape != expected:
            shapes = {name: a.shape for name, a in arrays.items()}
            raise ValueError(
                f"recording {index + 1}: t must be (N,) and the others (N, {robot.n}) for "
                f"{robot.n} joints, got {shapes}"
            )
