"""Quantities that a log can be read without, and holds in fewer than half of its rows."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence

from oed.counted import counted
from oed.experiment.importing.propose_columns import ColumnProposal
from oed.experiment.log_format import OPTIONAL
from oed.experiment.missing_rows import rarest
from oed.experiment.units import Quantity


def without_rarely_logged(
    logs: Sequence[ColumnProposal], stated: Collection[str], *, timed: bool
) -> list[ColumnProposal]:
    """The columns without such quantities, which are then left out of every log, with a note.

    Args:
        logs: With the columns that were found of each.
        stated: Quantities whose columns the user named: they are not left out.
        timed: Whether a column tells the time.
    """
    needed = ("t", "q", "tau") if timed else ("q", "tau")
    left_out: dict[Quantity, str] = {}
    for quantity in OPTIONAL:
        for log in logs:
            if quantity in log.columns and quantity not in stated and quantity not in left_out:
                note = _note(log, quantity, needed)
                left_out |= {quantity: note} if note else {}
    return [
        dataclasses.replace(
            log,
            columns={key: names for key, names in log.columns.items() if key not in left_out},
            units={key: units for key, units in log.units.items() if key not in left_out},
            notes=(*log.notes, *left_out.values()),
        )
        for log in logs
    ]


def _note(log: ColumnProposal, quantity: Quantity, needed: Sequence[str]) -> str:
    """Why a quantity is left out of this log; nothing if it is not."""
    others = [name for key in needed for name in log.columns.get(key, ())]
    names = log.columns[quantity]
    found = rarest(log.table.read([*others, *names]), others, names)
    if found is None:
        return ""
    name, lacking, rows = found
    return (
        f"{quantity}: left out, since column {name} holds no number in {lacking} of {counted(rows, 'row')} "
        "that have all others"
    )
