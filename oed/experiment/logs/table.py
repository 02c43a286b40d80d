"""What a log file holds: one table or several, each of named columns that share their rows."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Int
from numpy import ndarray

from oed.errors import DataSetError
from oed.input_file import MOST_NUMBERS

WILD = 1e20  # nanoseconds since 1970 are a hundredth of it, and nothing else is as large
MOST_HELD = 8 * MOST_NUMBERS  # [bytes]
Load = Callable[[tuple[str, ...]], Mapping[str, ndarray]]


@dataclass(frozen=True)
class Table:
    """Columns of numbers that share their rows.

    Attributes:
        columns: Names in the order of the file. Element i of a column of lists is `name[i]`.
        load: Gives the (N,) numbers of some of them; it may raise `DataSetError`.
        file: Where it comes from, for messages.
        first_row: Number of its first row, as a user counts in this file.
        header_row: Row that names the columns; None where they are named otherwise.
        name: Of the table within its file, such as a topic; "" where it is the only one.
        text: Facts about it that an import repeats, a line each.
        labels: What columns are called beside their names, such as the motors of a list.
        times: Columns of points in time, whatever they are called.
    """

    columns: tuple[str, ...]
    load: Load
    file: str
    first_row: int = 1
    header_row: int | None = None
    name: str = ""
    text: tuple[str, ...] = ()
    labels: Mapping[str, str] = field(default_factory=dict)
    times: tuple[str, ...] = ()

    def take(self, names: Sequence[str]) -> dict[str, ndarray]:
        """The (N,) finite numbers of some columns.

        Raises:
            DataSetError: If a name is missing or stands for two columns, or a value is no
                finite number.
        """
        values = self.read(names)
        self.check(values, np.arange(len(next(iter(values.values())))))
        return values

    def read(self, names: Sequence[str]) -> dict[str, ndarray]:
        """The (N,) numbers of some columns as they are logged, not finite where there are none.

        Raises:
            DataSetError: If a name is missing or stands for two columns, or holds no numbers.
        """
        for name in names:
            if name not in self.columns:
                raise DataSetError("missing", file=self.file, row=self.header_row, column=name)
            if self.columns.count(name) > 1:
                message = "two columns have this name"
                raise DataSetError(message, file=self.file, row=self.header_row, column=name)
        values = {name: np.asarray(column) for name, column in self.load(tuple(names)).items()}
        for name in names:
            if not len(values[name]):
                raise DataSetError("holds no row", file=self.file)
            if values[name].ndim != 1 or values[name].dtype.kind not in "iuf":
                message = (
                    f"holds {values[name].dtype} of shape {values[name].shape}, not a number a row"
                )
                raise DataSetError(message, file=self.file, column=name)
        return values

    def check(self, values: Mapping[str, ndarray], rows: Int[ndarray, " rows"]) -> None:
        """Refuse what is no number, in the rows that are used: those of others are not judged.

        Args:
            values: (N,) of `read`.
            rows: That are used, from 0.

        Raises:
            DataSetError: At the first such value.
        """
        for name, column in values.items():
            used = column[rows]
            wrong = np.flatnonzero(~np.isfinite(used))
            if len(wrong) == len(used):
                message = "holds no number: it was not logged"
                raise DataSetError(message, file=self.file, column=name)
            if wrong.size:
                some = f", here and in {len(wrong) - 1} more rows" if wrong.size > 1 else ""
                what = (
                    "no number" if np.isnan(used[wrong[0]]) else f"{used[wrong[0]]:g} is no number"
                )
                message = f"{what}{some}; remove such rows or repair the log"
                row = int(rows[wrong[0]]) + self.first_row
                raise DataSetError(message, file=self.file, row=row, column=name)
            wild = np.flatnonzero(np.abs(used) > WILD)
            if wild.size:
                message = f"{used[wild[0]]:g} is beyond anything a log can mean; repair the log"
                row = int(rows[wild[0]]) + self.first_row
                raise DataSetError(message, file=self.file, row=row, column=name)

    def elements(self, name: str) -> tuple[str, ...]:
        """Columns `name[0]`, `name[1]`, … of a column of lists, in order; none if it is not one."""
        pattern = re.compile(re.escape(name) + r"\[(\d+)\]")
        found = [
            (int(match[1]), column)
            for column in self.columns
            if (match := pattern.fullmatch(column))
        ]
        return tuple(column for _, column in sorted(found))


@dataclass(frozen=True)
class Log:
    """The tables of one log file.

    Attributes:
        file: Where it comes from, for messages.
        tables: At least one.
        passed_over: What else it holds, such as topics that carry no joint states.
    """

    file: str
    tables: tuple[Table, ...]
    passed_over: tuple[str, ...] = ()


def held(log: Log, most: int = MOST_HELD) -> Log:
    """The log with its columns kept, once they were read, for as long as it is.

    Args:
        log: Whose columns are parsed or loaded each time that they are asked for.
        most: Size of the columns that are kept [bytes]; others are read anew.
    """
    kept: dict[tuple[int, str], ndarray] = {}

    def once(table: int, load: Load) -> Load:
        def read(names: tuple[str, ...]) -> Mapping[str, ndarray]:
            new = tuple(name for name in names if (table, name) not in kept)
            found = load(new) if new else {}
            both = {n: found[n] if n in found else kept[table, n] for n in names}
            if sum(column.nbytes for column in (*kept.values(), *found.values())) <= most:
                kept.update({(table, name): column for name, column in found.items()})
            return both

        return read

    tables = (replace(table, load=once(i, table.load)) for i, table in enumerate(log.tables))
    return replace(log, tables=tuple(tables))


def table_of(
    arrays: Mapping[str, ndarray], file: str, *, name: str = "", text: tuple[str, ...] = ()
) -> Table:
    """A table of arrays at hand.

    Args:
        arrays: (N,) numbers of a column, or (N, m) whose columns become `name[0]` … `name[m-1]`.
        file: For messages.
        name: Of the table.
        text: Facts about it.
    """
    columns: dict[str, ndarray] = {}
    for key, array in arrays.items():
        if array.ndim == 1:
            columns[key] = array
        else:
            columns |= {f"{key}[{i}]": array[:, i] for i in range(array.shape[1])}
    return Table(
        tuple(columns),
        lambda names: {column: columns[column] for column in names},
        file,
        name=name,
        text=text,
    )
