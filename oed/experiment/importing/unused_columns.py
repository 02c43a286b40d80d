"""What of a log an import passed over: columns, tables, topics."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from oed.counted import as_one, counted, listed
from oed.experiment.importing.column_groups import grouped
from oed.experiment.importing.joint_names import common_start
from oed.experiment.importing.propose_columns import ColumnProposal
from oed.experiment.importing.read_log_values import RECEIVED, STAMP, episode_column

MOST_GROUPS = 8  # in the line


def unused_note(logs: Sequence[ColumnProposal]) -> tuple[str, ...]:
    """A line on what of some logs was not used, names that differ by joint together; none if all was.

    Args:
        logs: With the columns that are used of each.
    """
    groups = grouped(each for log in logs for each in _unused(log))
    if not groups:
        return ()
    shown = [as_one(names) for names in groups]
    count = counted(sum(map(len, groups)), "column or topic", "columns or topics")
    return (f"unused: {count}: {listed(shown, MOST_GROUPS, 'such groups')}",)


def _unused(log: ColumnProposal) -> Iterator[tuple[str, str]]:
    """Each name that is not used, after what it shares with those of other joints."""
    table = log.table
    # Of the two clocks of a bag, a note of its own says which.
    used = {f"{table.name}.{name}" for name in (STAMP, RECEIVED)} | {episode_column(table)}
    used |= {name for names in log.columns.values() for name in names}
    joints = _joints(log.columns["q"])
    for other in log.log.tables:
        if other.name != table.name:
            yield other.name, f"topic {other.name}"
            continue
        for name in other.columns:
            if name not in used:
                yield joints.sub("#", name), name
    yield from ((name, name) for name in log.log.passed_over)


def _joints(columns: Sequence[str]) -> re.Pattern[str]:
    """What differs between the columns of several joints, as a word of its own."""
    start = common_start(columns)
    end = common_start([name[start:][::-1] for name in columns])
    words = sorted((name[start : len(name) - end] for name in columns), key=len, reverse=True)
    either = "|".join(re.escape(word) for word in words if word)
    return re.compile(rf"(?<![A-Za-z0-9])(?:{either})(?![A-Za-z0-9])" if either else r"(?!)")
