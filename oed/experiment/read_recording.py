"""One recording from its log: which columns and rows, in SI, checked."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.counted import counted
from oed.errors import DataSetError
from oed.experiment.column_names import ColumnNames, find_columns
from oed.experiment.consistency_checks import check_repeats, check_speed, check_velocity
from oed.experiment.drive import Drive, TorqueKind
from oed.experiment.limit_checks import torque_notes
from oed.experiment.log_format import OPTIONAL, REPETITION, TEMPERATURE, TIME, LogFormat
from oed.experiment.logs.stamps import seconds_of_day
from oed.experiment.logs.table import Log
from oed.experiment.manifest import RecordingEntry
from oed.experiment.missing_rows import rows_with_numbers
from oed.experiment.recording import Recording
from oed.experiment.recording_checks import (
    check_positions,
    check_repetitions,
    check_rows,
    check_time,
    check_turns,
    derive_repetition,
    repetition_index,
)
from oed.experiment.state_clock import in_state_time
from oed.experiment.temperature import thermometer_notes
from oed.experiment.torque_faults import torque_fault_notes
from oed.experiment.units import JOINT_QUANTITIES, factor_to_si
from oed.largest_number import LARGEST
from oed.robot import Robot

OURS = re.compile(r"'((?:q|tau)_\d+)'")  # a column in a note, by our name


@dataclass(frozen=True)
class Samples:
    """The rows of one recording, in SI.

    Attributes:
        t: (N,) [s].
        joints: (N, n) by quantity [rad or m, rad/s or m/s, rad/s^2 or m/s^2, N m or N].
        others: (N, …) `repetition` and `temperature`, where there are any.
        lines: (N,) line of the log that each is of.
        notes: What was left out.
    """

    t: Float[ndarray, " samples"]
    joints: Mapping[str, Float[ndarray, "samples joints"]]
    others: Mapping[str, ndarray]
    lines: Int[ndarray, " samples"]
    notes: tuple[str, ...]


def read_recording(
    log: Log,
    entry: RecordingEntry,
    robot: Robot,
    log_format: LogFormat,
    *,
    drive: Drive,
    torque: TorqueKind,
) -> Recording:
    """Read, convert and check one recording.

    Args:
        log: The file.
        entry: Which rows of it, and what they are for.
        robot: Its joints, in the order of the columns.
        log_format: How the log is written.
        drive: With `current_to_torque`, if torques are currents.
        torque: How it was obtained.

    Raises:
        DataSetError: At the first fault, naming file, row and column as the log does.
    """
    names = find_columns(log, robot, log_format)
    samples = take_samples(names, entry, robot, log_format)
    try:
        return _checked(
            samples,
            names,
            entry,
            robot,
            drive=drive,
            torque=torque,
            named=bool(log_format.columns),
        )
    except DataSetError as error:
        if error.column is None or error.file.endswith(".toml"):
            raise
        raise error.with_column(names.logged_as(error.column)) from error


def take_samples(
    names: ColumnNames, entry: RecordingEntry, robot: Robot, log_format: LogFormat
) -> Samples:
    """The rows of a recording in SI, without those that repeat the row before or hold no number.

    Raises:
        DataSetError: If a value is no number that can be believed, or there is no such row.
    """
    table = names.table
    log_format = log_format.with_units(names.units)
    values = table.read(names.all)
    count = len(next(iter(values.values())))
    t = _time(names, values, count, log_format)
    optional = {name for key in OPTIONAL for name in names.fields.get(key, ())}
    rows, notes = rows_with_numbers(table, values, _cut(entry, t, table.file), optional)
    repeats = np.ones(len(rows), dtype=bool)
    repeats[0] = False
    for name, column in values.items():
        if name != REPETITION or len(values) > 1:
            repeats[1:] &= np.diff(column[rows]) == 0
    repeats &= log_format.rate is None
    if repeats.any():
        first = int(rows[repeats.argmax()]) + table.first_row
        some = counted(int(repeats.sum()), "row that repeats", "rows that repeat")
        what = f"without {some} the row before exactly"
        notes = (*notes, f"{table.file}: {what}, the first of them row {first}")
    rows = rows[~repeats]
    lines = rows + table.first_row
    joints = {
        quantity: log_format.to_si(quantity, _stacked(names, values, quantity)[rows], robot)
        for quantity in JOINT_QUANTITIES
        if quantity in names.fields
    }
    others: dict[str, ndarray] = {}
    if REPETITION in names.fields:
        others[REPETITION] = values[names.fields[REPETITION][0]][rows].astype(float)
    if TEMPERATURE in names.fields:
        others[TEMPERATURE] = log_format.celsius(_stacked(names, values, TEMPERATURE)[rows])
    samples = Samples(t[rows], joints, others, lines, notes)
    _check_sizes(samples, names)
    return samples


def _time(
    names: ColumnNames, values: Mapping[str, ndarray], count: int, log_format: LogFormat
) -> Float[ndarray, " samples"]:
    if log_format.rate is not None:
        return np.arange(count) / log_format.rate
    logged = values[names.fields[TIME][0]]
    factor = factor_to_si(TIME, log_format.unit(TIME) or "s")
    if logged.dtype.kind in "iu" and factor == 1e-9:
        return seconds_of_day(logged.astype(np.int64))
    return np.asarray(logged * factor if factor != 1 else logged, dtype=float)


def _cut(entry: RecordingEntry, t: Float[ndarray, " samples"], file: str) -> Int[ndarray, " rows"]:
    """The rows of the log that belong to a recording."""
    rows = np.arange(len(t))
    if entry.rows is not None:
        first, last = entry.rows
        if last > len(t):
            message = f"recording {entry.name!r}: rows end at {last}, but the log has {len(t)} rows"
            raise DataSetError(message, file=file)
        rows = rows[first - 1 : last]
    told = np.isfinite(t)
    if entry.span is not None and told.any():
        since = t - t[told.argmax()]
        within = np.flatnonzero((since >= entry.span[0]) & (since < entry.span[1]))
        # Rows whose time is missing are where they stand in the log.
        rows = np.arange(within[0], within[-1] + 1) if within.size else within
        rows = rows[np.isin(rows, within) | ~told[rows]]
        if not len(rows):
            start, end = entry.span
            message = (
                f"recording {entry.name!r}: no row from {start:g} s to {end:g} s; the log "
                f"lasts {since[told].max():.6g} s"
            )
            raise DataSetError(message, file=file)
    return rows


def _stacked(
    names: ColumnNames, values: Mapping[str, ndarray], quantity: str
) -> Float[ndarray, "samples columns"]:
    return np.column_stack([values[name] for name in names.fields[quantity]]).astype(float)


def _check_sizes(samples: Samples, names: ColumnNames) -> None:
    """Refuse what no quantity in SI can be."""
    arrays = {TIME: samples.t, **samples.joints, **samples.others}
    for quantity, array in arrays.items():
        columns = array.reshape(len(array), -1)
        if not np.abs(columns).max(initial=0.0) <= LARGEST:
            row, k = (int(i) for i in np.argwhere(np.abs(columns) > LARGEST)[0])
            fields = names.fields.get(quantity, (quantity,))
            message = f"{columns[row, k]:g} is beyond {LARGEST:g}; check its unit"
            raise DataSetError(
                message, file=names.table.file, row=int(samples.lines[row]), column=fields[k]
            )


def _checked(
    samples: Samples,
    names: ColumnNames,
    entry: RecordingEntry,
    robot: Robot,
    *,
    drive: Drive,
    torque: TorqueKind,
    named: bool,
) -> Recording:
    file, lines, t, q = names.table.file, samples.lines, samples.t, samples.joints["q"]
    check_time(t, file, lines)
    check_rows(t, robot.n, file)
    check_positions(q, robot, file, lines)
    check_turns(t, q, robot, file, lines)
    dq = samples.joints.get("dq")
    if dq is not None:
        check_velocity(t, q, dq, robot, file)
    check_speed(t, q, robot, file)
    repetition, is_derived = _repetition(samples, entry, file)
    period = entry.period if is_derived else None
    if repetition is not None:
        check_repeats(t, q, repetition, period, file)
    factor = drive.current_to_torque
    tau = samples.joints["tau"] * (1.0 if factor is None else factor)
    is_bare_current = torque == "current" and factor is None
    temperature = samples.others.get(TEMPERATURE)
    notes = (
        *samples.notes,
        *torque_notes(tau, robot, file, lines, is_bare_current=is_bare_current),
        *torque_fault_notes(t, q, tau, file, lines),
    )
    if temperature is not None:
        notes += tuple(thermometer_notes(temperature, robot.n, file, lines))
    # Who names the columns knows the others.
    unused = () if named else tuple(c for c in names.table.columns if c not in names.all)
    recording = Recording(
        name=entry.name,
        role=entry.role,
        t=t,
        q=q,
        tau=tau,
        dq=dq,
        ddq=samples.joints.get("ddq"),
        repetition=repetition,
        temperature=temperature,
        period=entry.period,
        source=file,
        unused_columns=unused,
        notes=tuple(OURS.sub(lambda column: repr(names.logged_as(column[1])), n) for n in notes),
    )
    return in_state_time(recording)


def _repetition(
    samples: Samples, entry: RecordingEntry, file: str
) -> tuple[Int[ndarray, " samples"] | None, bool]:
    """The index of each row's repetition, if any, and whether time alone tells it."""
    logged = samples.others.get(REPETITION)
    index = None if logged is None else repetition_index(logged, file, samples.lines)
    check_repetitions(samples.t, index, entry, file)
    if index is None and entry.repetitions is not None:
        return derive_repetition(samples.t, entry.repetitions, entry.period), True
    return index, False
