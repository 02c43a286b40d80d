"""A table that grows by a line a case, each with the digest of what made it."""

from __future__ import annotations

import csv
import io
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.report.json_file import write_atomically

Outcome = Mapping[str, str | int | float]
csv.field_size_limit(2**31 - 1)  # a cell may hold arrays
DIGEST = "digest"  # last column; a file of before there was one has none


@dataclass(frozen=True)
class Line:
    """A line that can be read.

    Attributes:
        key: Of its case.
        row: Cells by column, the digest aside.
        digest: Of what made it; empty where the file does not say.
    """

    key: tuple[str, ...]
    row: dict[str, str]
    digest: str


@dataclass(frozen=True)
class RowFile:
    """A CSV file that only grows while cases are done, a line a case.

    A case that is done again gets another line, which counts in place of the one before and stands
    alone once all are done.

    Attributes:
        path: The file.
        key_columns: Names of the columns of a case's key; they come first.
        value_columns: Names of the others.
    """

    path: Path
    key_columns: tuple[str, ...]
    value_columns: tuple[str, ...]

    @property
    def columns(self) -> tuple[str, ...]:
        """All columns in order, the digest's aside."""
        return (*self.key_columns, *self.value_columns)

    def rows(self) -> list[dict[str, str]]:
        """One row a case: of its last complete line.

        Raises:
            ValueError: If the file has other columns.
        """
        return [line.row for line in self.lines().values()]

    def rows_of(self, keys: Iterable[tuple[str, ...]]) -> list[dict[str, str]]:
        """The same, of some cases alone and in their order, whichever was done first.

        Args:
            keys: Of the cases; one that has no line is left out.
        """
        lines = self.lines()
        return [lines[key].row for key in keys if key in lines]

    def lines(self) -> dict[tuple[str, ...], Line]:
        """The last complete line of each case, in the order in which the cases came.

        Raises:
            ValueError: As `rows`.
        """
        return self._read()[0]

    def done(self, digests: Mapping[tuple[str, ...], str] | None = None) -> set[tuple[str, ...]]:
        """Keys of the complete lines.

        Args:
            digests: By key, of what would make the line now: one of another is not done. All
                lines are if None.
        """
        lines = self.lines()
        if digests is None:
            return set(lines)
        return {key for key, line in lines.items() if digests.get(key) == line.digest}

    def prepare(self) -> None:
        """Make the file with its header, end a line that was cut short, say which are damaged."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        if not self.path.is_file() or not self.path.stat().st_size:
            self._append((*self.columns, DIGEST))
            return
        lines, damaged = self._read()
        for number in damaged:
            sys.stderr.write(f"note: {self.path}, line {number}: cannot be read and is left out\n")
        whole = self.path.read_bytes()
        if not whole.endswith(b"\n"):
            os.truncate(self.path, whole.rfind(b"\n") + 1)
        if not whole.split(b"\n", 1)[0].rstrip().endswith(DIGEST.encode()):
            self._write(lines.values())

    def tidy(self) -> None:
        """Leave one line a case: those that others took the place of go, the damaged ones too."""
        lines, _ = self._read()
        if self.path.read_bytes().count(b"\n") > 1 + len(lines):
            self._write(lines.values())

    def append(self, key: tuple[str, ...], outcome: Outcome, digest: str = "") -> None:
        """Add a case's line whole, or not at all."""
        self._append((*key, *(outcome.get(column, "") for column in self.value_columns), digest))

    def _write(self, lines: Iterable[Line]) -> None:
        written = [[*line.row.values(), line.digest] for line in lines]
        write_atomically(self.path, "".join(map(_text, [[*self.columns, DIGEST], *written])))

    def _append(self, cells: Sequence[str | int | float]) -> None:
        text = _text(cells).encode("utf-8")
        handle = os.open(self.path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        before = os.fstat(handle).st_size
        try:
            while text:
                text = text[os.write(handle, text) :]
        except OSError as error:
            os.ftruncate(handle, before)
            message = (
                f"{error.strerror}; what was done is kept, the same command goes on from there"
            )
            raise OSError(error.errno, message, str(self.path)) from error
        finally:
            os.close(handle)

    def _read(self) -> tuple[dict[tuple[str, ...], Line], list[int]]:
        """Lines by key, and the numbers of those that are damaged."""
        if not self.path.is_file():
            return {}, []
        text = self.path.read_bytes().decode("utf-8", errors="replace")
        header, *body = text[: text.rfind("\n") + 1].split("\n")[:-1] or [""]
        if not header:
            return {}, []
        columns = tuple(_cells(header))
        if columns not in (self.columns, (*self.columns, DIGEST)):
            raise ValueError(
                f"{self.path} has the columns {list(columns)}, not {list(self.columns)}"
            )
        found: dict[tuple[str, ...], Line] = {}
        damaged = []
        for number, line in enumerate(body, start=2):
            cells = _cells(line)
            if len(cells) != len(columns) or "\ufffd" in line or "\0" in line:
                damaged.append(number)
                continue
            row = dict(zip(self.columns, cells, strict=False))
            key = tuple(row[column] for column in self.key_columns)
            found[key] = Line(key, row, cells[-1] if columns[-1] == DIGEST else "")
        return found, damaged


def _cells(line: str) -> list[str]:
    """Of one line; none where it is no line of CSV."""
    try:
        return next(csv.reader([line], strict=True), [])
    except csv.Error:
        return []


def _text(cells: Sequence[str | int | float]) -> str:
    """A line, whatever breaks of lines its cells hold."""
    stream = io.StringIO()
    plain = [" ".join(cell.splitlines()) if isinstance(cell, str) else cell for cell in cells]
    csv.writer(stream, lineterminator="\n").writerow(plain)
    return stream.getvalue()
