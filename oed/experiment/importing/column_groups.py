"""Names of columns that differ by a number, such as that of the joint, said together."""

from __future__ import annotations

import re
from collections.abc import Iterable

from oed.counted import MOST_SHOWN, as_one, listed
from oed.experiment.logs.table import Table


def grouped(named: Iterable[tuple[str, str]]) -> list[list[str]]:
    """Names of one family each, in the order of the first of each.

    Args:
        named: A name after what it shares with the others of its family but for numbers.
    """
    groups: dict[str, list[str]] = {}
    for family, name in named:
        names = groups.setdefault(re.sub(r"\d+", "#", family), [])
        if name not in names:
            names.append(name)
    return list(groups.values())


def listed_columns(table: Table) -> str:
    """The columns of a table for a message."""
    groups = grouped((name, name) for name in table.columns)
    return listed([as_one(names) for names in groups], MOST_SHOWN, "such groups")
