"""Rows of a log in which a column holds no number: they are rows that are missing.

What stands in the other columns of such a row is no sample. The time between the rows beside it is
then a step of the log as any other, and a gap where it is long (`signals.gaps`).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from jaxtyping import Bool, Int
from numpy import ndarray

from oed.counted import as_one, counted, listed
from oed.errors import DataSetError
from oed.experiment.logs.table import Table

MOST_GROUPS = 4  # of columns in a note


def rows_with_numbers(
    table: Table,
    values: Mapping[str, ndarray],
    rows: Int[ndarray, " rows"],
    optional: Collection[str] = (),
) -> tuple[Int[ndarray, " samples"], tuple[str, ...]]:
    """The rows in which every column holds a number that can be believed, and a note on the others.

    Args:
        table: That is read.
        values: (N,) of its columns.
        rows: Those of a recording, from 0.
        optional: Columns without which the recording would be one all the same.

    Raises:
        DataSetError: If a column holds no number, no row has one in each, an optional column has
            none in most of them, or a number cannot be believed.
    """
    empty = {name: np.isnan(column[rows]) for name, column in values.items()}
    for name, lacks in empty.items():
        if lacks.all():
            table.check({name: values[name]}, rows)
    needed = [lacks for name, lacks in empty.items() if name not in optional]
    whole = ~np.logical_or.reduce(needed)
    if not whole.any():
        message = (
            f"no row holds a number in each of {', '.join(n for n in empty if n not in optional)}: they were "
            "logged at other instants; log them together"
        )
        raise DataSetError(message, file=table.file)
    for name in optional:
        lacking = int((whole & empty[name]).sum())
        if is_rare(lacking, int(whole.sum())):
            message = (
                f"no number in {lacking} of {counted(int(whole.sum()), 'row')} that have all others: it was "
                "logged at another rate; leave this column out"
            )
            raise DataSetError(message, file=table.file, column=name)
        whole &= ~empty[name]
    kept = rows[whole]
    table.check(values, kept)
    return kept, () if whole.all() else (_note(table, empty, rows[~whole]),)


def rarest(
    values: Mapping[str, ndarray], needed: Collection[str], names: Collection[str]
) -> tuple[str, int, int] | None:
    """The column that lacks a number in most rows that are whole, how many it lacks, and of how many.

    Args:
        values: (N,) of all these columns.
        needed: Columns that make a row whole.
        names: Columns that are judged.

    Returns:
        None if no column is logged so rarely, or no row is whole.
    """
    whole = np.logical_and.reduce([~np.isnan(values[name]) for name in needed])
    lacking = {name: int(np.isnan(values[name][whole]).sum()) for name in names}
    name = max(lacking, key=lambda one: lacking[one])
    rows = int(whole.sum())
    return (name, lacking[name], rows) if is_rare(lacking[name], rows) else None


def is_rare(lacking: int, rows: int) -> bool:
    """Whether a column was logged at another rate than the rows."""
    return 2 * lacking > rows


def _note(
    table: Table, empty: Mapping[str, Bool[ndarray, " rows"]], missing: Int[ndarray, " missing"]
) -> str:
    """How many rows are missing, and for which columns, those that miss the same together."""
    groups: dict[bytes, list[str]] = {}
    for name, lacks in empty.items():
        if lacks.any():
            groups.setdefault(lacks.tobytes(), []).append(name)
    said = [
        f"{lacks.count(1)} in column{'s' if len(names) > 1 else ''} {as_one(names)}"
        for lacks, names in groups.items()
    ]
    some = counted(len(missing), "row")
    return (
        f"{table.file}: {some} without a number, taken as missing: "
        f"{listed(said, MOST_GROUPS, 'such groups')}; the first of them row {missing[0] + table.first_row}"
    )
