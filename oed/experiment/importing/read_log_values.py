"""The numbers of a log whose columns were found: its clock chosen, its units proposed."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.errors import DataSetError
from oed.experiment.importing.column_groups import listed_columns
from oed.experiment.importing.propose_columns import ColumnProposal
from oed.experiment.importing.propose_units import UnitProposal, propose_units
from oed.experiment.importing.quantity_names import EPISODES
from oed.experiment.log_format import LogFormat
from oed.experiment.logs.table import Table
from oed.experiment.missing_rows import rows_with_numbers
from oed.experiment.recording_checks import check_rows
from oed.experiment.torque_faults import HELD_ROWS
from oed.experiment.units import factor_to_si
from oed.robot import Robot

SAME_SPAN = 0.01  # relative difference of two clocks of one log that both go right
STARTS_AT_ZERO = 1e-3  # [s] since midnight: a clock of its own, not the time of day
SAME_STAMP = 1e-6  # [s] by which two clocks of one log may be rounded differently
STAMP, RECEIVED = "stamp", "received"


@dataclass(frozen=True)
class LogValues:
    """What one log holds, as far as it is needed to divide it.

    Attributes:
        columns: Names, with the clock that was chosen.
        units: In which they are logged.
        t: (N,) time [s].
        q: (N, n) position [rad or m], without signs and zeros that a user may state.
        episode: (N,) index of the episode; None where there are none.
        rows: (N,) of the log that these are, from 0.
        logged: How many rows the log has.
        notes: What was concluded.
        left_out: A word on the other rows.
    """

    columns: ColumnProposal
    units: UnitProposal
    t: Float[ndarray, " samples"]
    q: Float[ndarray, "samples joints"]
    episode: Int[ndarray, " samples"] | None
    rows: Int[ndarray, " samples"]
    logged: int
    notes: tuple[str, ...]
    left_out: tuple[str, ...]


def read_values(
    logs: Sequence[ColumnProposal],
    robot: Robot,
    stated: Mapping[str, tuple[str, ...]],
    rate: float | None,
    ticks_per_turn: float | None,
) -> list[LogValues]:
    """Read the logs in units that are those of the first."""
    first: LogValues | None = None
    found = []
    for log in logs:
        columns, notes = _with_clock(log, rate)
        arrays = {
            key: np.column_stack(list(columns.table.read(names).values())).astype(float)
            for key, names in columns.columns.items()
            if key in ("q", "dq", "tau") or (key == "t" and rate is None)
        }
        rows, dead = _logged_rows(arrays, columns)
        logged = len(arrays["q"])
        arrays = {key: values[rows] for key, values in arrays.items()}
        units = first.units if first else propose_units(arrays, robot, {**columns.units, **stated})
        if ticks_per_turn is not None:
            units = dataclasses.replace(units, ticks_per_turn=ticks_per_turn)
        if rate is None:
            t = arrays["t"][:, 0] * factor_to_si("t", units.units.get("t", ("s",))[0])
        else:
            t = rows / rate
        check_rows(t, robot.n, columns.table.file)
        values = LogValues(
            columns,
            units,
            t,
            _positions(arrays["q"], units, robot, columns),
            _episodes(columns, rows),
            rows,
            logged,
            (*notes, *units.notes),
            dead,
        )
        first = first or values
        found.append(values)
    return found


def _positions(
    logged: Float[ndarray, "samples joints"],
    units: UnitProposal,
    robot: Robot,
    columns: ColumnProposal,
) -> Float[ndarray, "samples joints"]:
    ticks = units.ticks_per_turn
    log_format = LogFormat(
        units={key: value for key, value in units.units.items() if key == "q"},
        ticks_per_turn=None if ticks is None else np.full(robot.n, ticks),
        zero=units.zero,
    )
    try:
        return log_format.to_si("q", logged, robot)
    except ValueError as error:
        raise DataSetError(
            str(error), file=columns.table.file, column=columns.columns["q"][0]
        ) from error


def _logged_rows(
    arrays: Mapping[str, Float[ndarray, "logged columns"]], columns: ColumnProposal
) -> tuple[Int[ndarray, " samples"], tuple[str, ...]]:
    """The rows that were logged whole, and a word on those at the ends.

    A logger that starts before the drives report writes no number for them, or zero for all.
    """
    whole = np.logical_and.reduce([np.isfinite(values).all(axis=1) for values in arrays.values()])
    reports = whole & (arrays["tau"] != 0).any(axis=1)
    table, count = columns.table, len(whole)
    start, end = _dead(whole, reports), count - _dead(whole[::-1], reports[::-1])
    names = [name for key in arrays for name in columns.columns[key]]
    values = dict(zip(names, np.hstack(list(arrays.values())).T, strict=True))
    rows, _ = rows_with_numbers(table, values, np.arange(start, end), columns.columns.get("dq", ()))
    parts = ((0, start), (end, count))
    said = [f"{a + table.first_row} to {b - 1 + table.first_row}" for a, b in parts if b > a]
    note = (
        f"roles: {table.file}, rows {' and '.join(said)}, where the drives do not report, left out"
    )
    return rows, (note,) if said else ()


def _dead(whole: Bool[ndarray, " samples"], reports: Bool[ndarray, " samples"]) -> int:
    """Rows before the first that is whole, and before a torque after zeros as long as no sensor holds."""
    zeros = int(reports.argmax())
    return zeros if zeros >= HELD_ROWS else int(whole.argmax())


def _episodes(
    columns: ColumnProposal, rows: Int[ndarray, " samples"]
) -> Int[ndarray, " samples"] | None:
    name = episode_column(columns.table)
    if name is None:
        return None
    values = columns.table.read([name])
    columns.table.check(values, rows)
    return values[name][rows].astype(np.int64)


def episode_column(table: Table) -> str | None:
    """The column that numbers the episodes of a log; None if there is none."""
    return next((name for name in EPISODES if name in table.columns), None)


def _with_clock(
    columns: ColumnProposal, rate: float | None
) -> tuple[ColumnProposal, tuple[str, ...]]:
    """The columns with the better of a bag's two clocks, and why; others as they are."""
    table = columns.table
    if rate is not None:
        return columns, (f"t: {rate:g} rows a second, as given",)
    if "t" not in columns.columns:
        message = (
            "no column of time found; name it, as in --columns t=NAME, or say how many rows there "
            f"are a second, as in --rate 100. Columns: {listed_columns(table)}"
        )
        raise DataSetError(message, file=table.file)
    stamp, received = (f"{table.name}.{name}" if table.name else name for name in (STAMP, RECEIVED))
    if columns.columns["t"] != (stamp,) or received not in table.columns:
        return columns, (f"t: column {columns.columns['t'][0]}",)
    clocks = table.take([stamp, received])
    chosen, why = _better_clock(clocks[stamp], clocks[received])
    name = stamp if chosen == STAMP else received
    changed = dataclasses.replace(columns, columns={**columns.columns, "t": (name,)})
    return changed, (f"t: {name}, {why}",)


def _better_clock(
    stamp: Float[ndarray, " samples"], received: Float[ndarray, " samples"]
) -> tuple[str, str]:
    """The stamps of whoever measured, unless they stand still, run back or go at another rate.

    A recorder's stamps come after the way through the network, each by another delay.
    """
    spans = float(np.ptp(stamp)), float(np.ptp(received))
    if spans[0] == 0:
        return RECEIVED, "since the headers carry no time"
    if (np.diff(stamp) < 0).any():
        return RECEIVED, "since the headers' stamps run back"
    apart = np.abs((stamp - stamp[0]) - (received - received[0]))
    if spans[1] > 0 and abs(spans[0] / spans[1] - 1) > SAME_SPAN:
        why = f"since the headers' stamps span {spans[0]:.4g} s while {spans[1]:.4g} s passed"
        return RECEIVED, why
    start = ", from a clock that starts at zero" if stamp[0] < STARTS_AT_ZERO else ""
    late = float(apart.max())
    other = f"differ by up to {1e3 * late:.2g} ms" if late > SAME_STAMP else "say the same"
    return STAMP, f"made where it was measured{start}; the recorder's stamps {other}"
