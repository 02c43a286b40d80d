"""Tables: aligned text for a terminal, Markdown for a summary, CSV for the next program."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from oed.report.json_file import write_atomically

Cell = str | int | float | bool | None | np.generic
Row = Mapping[str, Cell]

MISSING = "–"


def format_cell(value: Cell, *, digits: int = 4) -> str:
    """A cell as a reader wants it.

    Args:
        value: The value; None and NaN become a dash, what is beyond all numbers a word.
        digits: Significant digits of a number with a fraction.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return MISSING
    if isinstance(value, float) and math.isinf(value):
        return "infinite" if value > 0 else "-infinite"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        # "#" keeps trailing zeros: 0.1000 says four digits are known; the bare point goes.
        return f"{value:#.{digits}g}".rstrip(".").replace(".e", "e")
    return str(value)


def text_table(
    rows: Sequence[Row], *, columns: Sequence[str] | None = None, digits: int = 4
) -> str:
    """An aligned plain-text table: numbers to the right, text to the left.

    Args:
        rows: One mapping a row; a key that a row lacks is an empty cell.
        columns: Keys to show, in this order; all, in order of first appearance, if None.
        digits: Significant digits of numbers with a fraction.
    """
    columns = column_names(rows) if columns is None else list(columns)
    cells = _formatted(rows, columns, digits)
    widths = [max(map(len, column)) for column in zip(columns, *cells, strict=True)]
    right = [is_numeric(rows, column) for column in columns]

    def line(values: Sequence[str]) -> str:
        aligned = (
            v.rjust(width) if to_right else v.ljust(width)
            for v, width, to_right in zip(values, widths, right, strict=True)
        )
        return "  ".join(aligned).rstrip()

    rule = "  ".join("-" * width for width in widths)
    return "\n".join([line(columns), rule, *map(line, cells)]) + "\n"


def markdown_table(
    rows: Sequence[Row], *, columns: Sequence[str] | None = None, digits: int = 4
) -> str:
    """A Markdown table; arguments as for `text_table`."""
    columns = column_names(rows) if columns is None else list(columns)
    rules = ["---:" if is_numeric(rows, column) else "---" for column in columns]
    lines = [list(columns), rules, *_formatted(rows, columns, digits)]
    return "".join("| " + " | ".join(map(_escape, line)) + " |\n" for line in lines)


def write_csv(
    path: str | Path, rows: Sequence[Row], *, columns: Sequence[str] | None = None
) -> None:
    """Write rows with a header, whole or not at all, every digit of every number kept.

    Raises:
        ValueError: If there are no rows and no columns to write, or a row has other keys.
    """
    columns = column_names(rows) if columns is None else list(columns)
    if not columns:
        raise ValueError("neither rows nor columns: the file would say nothing")
    stream = io.StringIO()
    writer = csv.DictWriter(stream, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows({key: _exact(value) for key, value in row.items()} for row in rows)
    write_atomically(path, stream.getvalue())


def read_csv(path: str | Path) -> list[dict[str, Any]]:
    """Rows that `write_csv` wrote: integers, numbers, booleans and missing cells come back.

    Text that looks like one of these comes back as that.

    Raises:
        ValueError: If a row has more or fewer cells than the header.
    """
    with Path(path).open(encoding="utf-8", newline="") as stream:
        header, *lines = csv.reader(stream)
    for number, cells in enumerate(lines, start=2):
        if len(cells) != len(header):
            raise ValueError(f"{path}, row {number}: {len(cells)} cells, header {len(header)}")
    return [dict(zip(header, map(parse_cell, cells), strict=True)) for cells in lines]


def column_names(rows: Sequence[Row]) -> list[str]:
    """The keys of all rows, in order of first appearance."""
    return list(dict.fromkeys(key for row in rows for key in row))


def is_numeric(rows: Sequence[Row], column: str) -> bool:
    """Whether a column holds numbers only, missing cells aside."""
    values = [row[column] for row in rows if row.get(column) is not None]
    return bool(values) and all(
        isinstance(v, (int, float, np.number)) and not isinstance(v, bool) for v in values
    )


def _formatted(rows: Sequence[Row], columns: Sequence[str], digits: int) -> list[list[str]]:
    return [[format_cell(row.get(c), digits=digits) for c in columns] for row in rows]


def _escape(text: str) -> str:
    return text.replace("|", r"\|").replace("\n", " ")


def number_of(value: Cell) -> float:
    """The number in a cell.

    Raises:
        TypeError: If there is none.
    """
    if not isinstance(value, int | float):
        raise TypeError(f"{value!r} is no number")
    return float(value)


def _exact(value: Cell) -> str:
    if isinstance(value, np.generic):
        value = value.item()
    return "" if value is None else str(value)


def parse_cell(text: str) -> Cell:
    """What was written as this text, as far as it tells: a number, a boolean, None or text."""
    if text in ("True", "False"):
        return text == "True"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text or None
