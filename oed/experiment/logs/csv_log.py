"""Text tables: CSV of any dialect, and what `ros2 topic echo --csv` writes.

Parsed by NumPy at once. Only when that shows a fault is the file walked cell by cell
(`csv_fault`) to say where it is.
"""

from __future__ import annotations

import dataclasses
import io
import re
import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy import ndarray

from oed.counted import counted
from oed.errors import DataSetError
from oed.experiment.logs.csv_dialect import CsvText, read_csv_text
from oed.experiment.logs.csv_encoding import WINDOWS
from oed.experiment.logs.csv_fault import find_fault
from oed.experiment.logs.registry import log_reader
from oed.experiment.logs.ros_echo import NANOSEC, SEC, EchoLayout, echo_layout
from oed.experiment.logs.table import Log, Table

EMPTY_CELL = re.compile(rb"(?:(?<=[,\n])|^)[ \t]*(?=[,\n])")


@log_reader(".csv", ".txt", ".tsv", ".dat")
def read_csv(path: Path) -> Log:
    """Read a text table.

    Raises:
        DataSetError: If it is empty, truncated, no text, or its rows differ in length.
    """
    file = str(path)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise DataSetError(f"cannot be read: {error}", file=file) from error
    text = read_csv_text(content, file)
    fault = _fault(text, (), file) if not _is_rectangular(text) else None
    if fault is not None:
        raise fault
    line = text.body.partition(b"\n")[0].decode()
    echo = echo_layout(line) if text.header_row is None else None
    if echo is not None:
        return Log(file, (_echo_table(dataclasses.replace(text, header=echo.header), echo, file),))
    return Log(
        file,
        (
            Table(
                text.header,
                lambda names: _load(text, names, file),
                file,
                first_row=text.first_row,
                header_row=text.header_row,
                text=_said(text),
                times=text.times,
            ),
        ),
    )


def _said(text: CsvText) -> tuple[str, ...]:
    """What an import repeats of how a file was read."""
    lines = counted(text.above, "line")
    above = (f"passed over: {lines} above the names of the columns",) if text.above else ()
    return (*above, *((f"read as {WINDOWS} text",) if text.encoding == WINDOWS else ()))


def _echo_table(text: CsvText, echo: EchoLayout, file: str) -> Table:
    """Positions, velocities and efforts by joint, beside the two cells of the stamp."""
    for i, joint in zip(echo.names_at, echo.joints, strict=True):
        names = parse_cells(text, (i,), str)[i]
        other = np.flatnonzero(names != joint)
        if other.size:
            row = int(other[0])
            message = (
                f"joint {joint!r} is {names[row]!r} in this message; log one source of joint states"
            )
            raise DataSetError(message, file=file, row=row + text.first_row, column=echo.header[i])

    what = "read as the CSV of `ros2 topic echo` of sensor_msgs/msg/JointState"
    told = (SEC, NANOSEC, *text.header[echo.names_at.stop :])
    return Table(
        told,
        lambda names: _load(text, names, file),
        file,
        first_row=text.first_row,
        text=(what,),
    )


def _load(text: CsvText, names: tuple[str, ...], file: str) -> Mapping[str, ndarray]:
    wanted = {text.header.index(name): name for name in names}
    try:
        try:
            values = parse_cells(text, tuple(wanted), np.float64)
        except ValueError:
            filled = EMPTY_CELL.sub(b"nan", text.body)
            values = parse_cells(dataclasses.replace(text, body=filled), tuple(wanted), np.float64)
    except (ValueError, OverflowError) as error:
        fault = DataSetError(f"cannot be parsed: {error}", file=file)
    else:
        if not any(np.isinf(column).any() for column in values.values()):
            return {wanted[i]: column for i, column in values.items()}
        fault = DataSetError("cannot be parsed as numbers", file=file)
    raise _fault(text, names, file) or fault


def parse_cells(text: CsvText, columns: tuple[int, ...], kind: type) -> dict[int, ndarray]:
    """The cells of some columns, by the column's place from 0.

    Raises:
        ValueError: If a cell is nothing of that kind, or a line is empty.
    """
    with warnings.catch_warnings(action="ignore", category=UserWarning):  # there are no rows
        cells = np.loadtxt(
            io.BytesIO(text.body),
            dtype=kind,
            comments=None,
            delimiter=",",
            usecols=columns,
            ndmin=2,
            encoding="utf-8",
        )
    if len(cells) != text.body.count(b"\n"):  # empty lines are passed over
        raise ValueError("there are empty lines")
    return dict(zip(columns, cells.T, strict=True))


def _fault(text: CsvText, names: tuple[str, ...], file: str) -> DataSetError | None:
    return find_fault(
        text.body.decode(),
        text.header,
        names,
        file,
        is_complete=text.is_complete,
        first_row=text.first_row,
    )


def _is_rectangular(text: CsvText) -> bool:
    """Whether the last line is whole, and each has one comma fewer than there are columns."""
    letters = np.frombuffer(text.body, dtype=np.uint8)
    ends = np.flatnonzero(letters == ord("\n"))
    commas = np.flatnonzero(letters == ord(","))
    upto = np.searchsorted(commas, ends)
    return text.is_complete and bool((np.diff(upto, prepend=0) == len(text.header) - 1).all())
