"""How a text file separates its numbers, and the same numbers separated by commas.

Whatever a spreadsheet or a logger wrote (semicolons, tabs, blanks, decimal commas, quotes, comments
or other lines above, a header of one line, of two or none, a line of units, times of day) becomes one
kind of text, line for line, so that a fault is still named by the line that the user sees.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from typing import get_args

from oed.errors import DataSetError
from oed.experiment.logs.clock_text import DATE, clock_seconds, is_clock
from oed.experiment.logs.csv_encoding import decode
from oed.experiment.logs.csv_fault import NUMBER
from oed.experiment.units import Quantity
from oed.experiment.units_in_names import is_unit

SAMPLE = 20  # lines that tell how a file is written
MOST_ABOVE = 100  # lines that a logger may write above the names
LEAST_COLUMNS = 3  # of time, position and torque
COMMENTS = ("#", "%")
SEPARATOR_LINE = re.compile(r'"?sep=(.)"?\s*', re.IGNORECASE)  # spreadsheets write it as line 1
TWO_NUMBERS = re.compile(r"[\d.,eE+-]*\d\s+[+-]?[\d.,][\d.,eE+-]*")


@dataclass(frozen=True)
class CsvText:
    """Text whose numbers are separated by commas and have decimal points.

    Attributes:
        header: A name for each column: those of the file, or "1", "2", … where it has none; with
            its unit in brackets where a line below the names states units.
        body: The rows, each ended by a line feed; the last only if it is so in the file.
        first_row: Line of the file that is the first of `body`.
        header_row: Line of the header; None if there is none.
        is_complete: Whether the last line of the file ends with a line break.
        encoding: Of the file, by name.
        above: Lines above the header that are neither comments nor rows.
        times: Columns whose cells were times that are written out.
    """

    header: tuple[str, ...]
    body: bytes
    first_row: int
    header_row: int | None
    is_complete: bool
    encoding: str
    above: int = 0
    times: tuple[str, ...] = ()


def read_csv_text(content: bytes, file: str) -> CsvText:
    """Find out how a file is written, and write it with commas.

    Raises:
        DataSetError: If it is no text, holds no row, or a quote is left open.
    """
    decoded, encoding = decode(content, file)
    text = decoded.encode().replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    skipped, separator, comment, text = _without_top(text)
    if not text.strip():
        raise DataSetError("empty; it needs one row per sample", file=file)
    passed = _lines_above(text, separator)
    if passed:
        skipped, text = skipped + passed, text.split(b"\n", passed)[passed]
    sample = [line.decode() for line in text.split(b"\n", SAMPLE)[:SAMPLE]]
    separator = separator or _separator(sample)
    first, _, rest = text.partition(b"\n")
    names = _cells(first.decode(), separator, file, skipped + 1)
    has_header = not _is_value(names[0])
    body, first_row = (rest, skipped + 2) if has_header else (text, skipped + 1)
    header_row = skipped + 1 if has_header else None
    second, _, below = rest.partition(b"\n")
    units = _cells(second.decode(), separator, file, first_row) if has_header else ()
    if _are_units(units) and len(units) == len(names):
        names = tuple(_with_unit(name, unit) for name, unit in zip(names, units, strict=True))
        body, first_row = below, first_row + 1
    elif len(set(names)) < len(names) == len(units) and not any(map(_is_value, units)):
        names = _joined(names, units)
        body, first_row = below, first_row + 1
    if not has_header:
        above = _cells(comment, separator, file, skipped) if comment else ()
        is_named = len(above) == len(names) and not any(map(_is_value, above))
        header_row = skipped if is_named else None
        names = above if is_named else tuple(str(i + 1) for i in range(len(names)))
    is_complete = text.endswith(b"\n")
    body = body.rstrip(b"\n") + b"\n" if is_complete else body
    if not body.strip():
        raise DataSetError("holds a header but no row", file=file, row=first_row)
    header = tuple(name or f"column {i + 1}" for i, name in enumerate(names))
    body, clocks = _with_seconds(_with_commas(body, separator, file, first_row))
    times = tuple(header[i] for i in clocks if i < len(header))
    return CsvText(header, body, first_row, header_row, is_complete, encoding, passed, times)


def _without_top(text: bytes) -> tuple[int, str, str, bytes]:
    """Number of lines above the table, the separator named there, the last comment, the table."""
    skipped, separator, comment = 0, "", ""
    while text:
        line, _, rest = text.partition(b"\n")
        top = line.decode().strip()
        named = SEPARATOR_LINE.fullmatch(top)
        if named and not skipped:
            separator = named[1]
        elif top.startswith(COMMENTS):
            comment = top.lstrip("".join(COMMENTS)).strip()
        elif top:
            break
        skipped, text = skipped + 1, rest
    return skipped, separator, comment, text


def _lines_above(text: bytes, separator: str) -> int:
    """How many lines stand above that of the names, such as of who recorded what.

    The names are as many as the numbers in the first two rows of these, and stand right above them,
    in one line or two. What is not so is left to be named as a fault.
    """
    lines = [line.decode() for line in text.split(b"\n", MOST_ABOVE)[:MOST_ABOVE]]
    for k in range(1, len(lines) - 1):
        own = separator or _separator(lines[k : k + SAMPLE])
        rows = [_split(line, own) for line in lines[k : k + 2]]
        if len(rows[0]) >= LEAST_COLUMNS and all(map(_is_row, rows)):
            start = k
            while start and len(_split(lines[start - 1], own)) == len(rows[0]):
                start -= 1
            return start if start < k and not _is_row(_split(lines[start], own)) else 0
    return 0


def _is_row(cells: list[str]) -> bool:
    """Whether there are numbers or times in a line, and nothing else."""
    bare = [cell.strip().strip("\"'") for cell in cells]
    return any(bare) and all(not cell or _is_value(cell) for cell in bare)


def _joined(names: tuple[str, ...], below: tuple[str, ...]) -> tuple[str, ...]:
    """Names in two lines, of which one above holds for those behind it that are empty."""
    found, last = [], ""
    for name, rest in zip(names, below, strict=True):
        last = name or last
        found.append(f"{last}.{rest}" if rest else last)
    return tuple(found)


def _separator(lines: list[str]) -> str:
    """What stands between the cells of these lines: the first that cuts all alike, else a comma."""
    whole = [line for line in lines if line.strip()]
    for separator in (";", "\t", ",", " "):
        cells = [_split(line, separator) for line in whole[:-1] or whole]
        is_alike = len({len(row) for row in cells}) == 1 and len(cells[0]) > 1
        if is_alike and not any(
            TWO_NUMBERS.fullmatch(cell.strip()) for row in cells for cell in row
        ):
            return separator
    # A faulty row among them must not change what the others say.
    first = whole[0]
    return next((s for s in (";", "\t", ",") if s in first), " " if " " in first.strip() else ",")


def _split(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    return (
        line.split(separator) if '"' not in line else next(csv.reader([line], delimiter=separator))
    )


def _cells(line: str, separator: str, file: str, row: int) -> tuple[str, ...]:
    try:
        cells = _split(line, separator)
    except csv.Error as error:
        raise DataSetError(f"cannot be parsed: {error}", file=file, row=row) from error
    return tuple(cell.strip().strip("\"'").strip() for cell in cells)


def _is_value(cell: str) -> bool:
    """Whether a cell is a number or a time, and no name."""
    point = cell.replace(",", ".", 1)
    return NUMBER.fullmatch(point) is not None or is_clock(point) or bool(DATE.fullmatch(cell))


def _are_units(cells: tuple[str, ...]) -> bool:
    """Whether a line says in which units the columns below it are; some may have none."""
    stated = [cell.strip("[]() ") for cell in cells]
    return any(stated) and all(
        not unit or any(is_unit(unit, quantity) for quantity in get_args(Quantity))
        for unit in stated
    )


def _with_unit(name: str, unit: str) -> str:
    bare = unit.strip("[]() ")
    return f"{name} [{bare}]" if bare else name


def _with_commas(body: bytes, separator: str, file: str, first_row: int) -> bytes:
    if b'"' in body:
        return _unquoted(body.decode(), separator, file, first_row)
    if separator == ",":
        return body
    # Where commas do not separate cells they stand for decimal points.
    body = body.replace(b",", b".")
    if separator == " ":
        return b"\n".join(b",".join(line.split()) for line in body.split(b"\n"))
    return body.replace(separator.encode(), b",")


def _with_seconds(body: bytes) -> tuple[bytes, list[int]]:
    """The rows with seconds in place of times that are written out, and which cells these are.

    Which, the first row tells.
    """
    lines = body.decode().split("\n")
    clocks = [i for i, cell in enumerate(lines[0].split(",")) if is_clock(cell)]
    if not clocks:
        return body, clocks
    rows = [line.split(",") for line in lines]
    for i in clocks:
        within = [row for row in rows if len(row) > i]
        for row, seconds in zip(within, clock_seconds([row[i] for row in within]), strict=True):
            row[i] = seconds
    return "\n".join(map(",".join, rows)).encode(), clocks


def _unquoted(body: str, separator: str, file: str, first_row: int) -> bytes:
    lines = []
    for i, line in enumerate(body.split("\n")):
        try:
            rows = list(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True))
        except csv.Error as error:
            message = f"a quote is not closed, or stands within a cell ({error}); repair the log"
            raise DataSetError(message, file=file, row=first_row + i) from error
        lines.append(",".join(cell.replace(",", ".") for cell in (rows[0] if rows else ())))
    return "\n".join(lines).encode()
