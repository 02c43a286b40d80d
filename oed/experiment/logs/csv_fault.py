"""Where a CSV file is at fault: the slow walk, taken only once a fault is known to exist."""

from __future__ import annotations

import re
from collections.abc import Collection
from math import isfinite

from oed.counted import counted
from oed.errors import DataSetError

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
MISSING = {"", "nan"}  # which whoever reads that row judges
NOT_A_NUMBER = {"inf", "infinity"}
REPAIR = "repair such cells, or leave them empty: their rows then count as missing"


def find_fault(
    body: str,
    header: tuple[str, ...],
    wanted: Collection[str],
    file: str,
    *,
    is_complete: bool,
    first_row: int = 2,
) -> DataSetError | None:
    """The first fault of a CSV file's rows.

    Args:
        body: The lines after the header, separated by line feeds.
        header: Names of the columns.
        wanted: Those that must hold numbers.
        file: Name for the message.
        is_complete: Whether the last line of the file ends with a line break.
        first_row: Line of the file that is the first of `body`.
    """
    lines = body.removesuffix("\n").split("\n")
    for i, line in enumerate(lines):
        is_last = i == len(lines) - 1
        message, column = _line_fault(line, header, wanted, is_last=is_last)
        if message:
            return DataSetError(message, file=file, row=i + first_row, column=column)
    if not is_complete:
        message = (
            "the last line has no line break, so its last number may have been cut off; "
            "end it with a line break if it is whole, else delete it"
        )
        return DataSetError(message, file=file, row=len(lines) + first_row - 1, column=header[-1])
    return None


def _line_fault(
    line: str, header: tuple[str, ...], wanted: Collection[str], *, is_last: bool
) -> tuple[str, str | None]:
    if not line.strip():
        return "empty line; delete it, or repair the log if a sample is missing", None
    cells = line.split(",")
    if len(cells) < len(header):
        what = "the last line is truncated: it" if is_last else "the row"
        missing = header[len(cells)]
        return (
            f"{what} holds {len(cells)} of {counted(len(header), 'column')}; delete or repair it",
            missing,
        )
    if len(cells) > len(header):
        hint = "decimal commas?" if ";" in line else "a comma inside a number or text?"
        return (
            f"the row holds {len(cells)} cells for {counted(len(header), 'column')} ({hint})",
            None,
        )
    for name, cell in zip(header, cells, strict=True):
        fault = _cell_fault(cell.strip()) if name in wanted else ""
        if fault:
            return fault, name
    return "", None


def _cell_fault(cell: str) -> str:
    if cell.lower().lstrip("+-") in MISSING:
        return ""
    if cell.lower().lstrip("+-") in NOT_A_NUMBER:
        return f"{cell} is not a finite number; {REPAIR}"
    if not NUMBER.fullmatch(cell):
        hint = f"; {REPAIR}"
        if NUMBER.fullmatch(cell.strip("\"'")):
            hint = "; write numbers without quotes"
        elif ":" in cell:
            hint = "; write times as 10:20:30.5 or 2026-01-31T10:20:30.5 throughout"
        return f"{cell[:40]!r} is not a number{hint}"
    if not isfinite(float(cell)):
        return f"{cell[:40]} is beyond what a computer can hold; repair the log"
    return ""
