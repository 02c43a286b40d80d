"""Which columns were taken where several are of one quantity of the same joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from oed.experiment.importing.layouts import (
    STEMS,
    TORQUES,
    Named,
    as_one,
    columns_of,
    torques_of,
)
from oed.experiment.importing.name_words import Source
from oed.experiment.units import Quantity

SAID: tuple[Source, ...] = ("measured", "", "commanded")


def of_same_joints(found: Sequence[list[Named]], order: Sequence[Named]) -> list[Named]:
    """The first stem with a column for each of these joints, in their order; none if there is no such."""
    return next(iter(_all_of_same_joints(found, order)), [])


def taken_notes(called: Mapping[str, str], chosen: Mapping[Quantity, Sequence[Named]]) -> list[str]:
    """A line on each quantity that the log holds more than once.

    Args:
        called: What each column is called, by its name.
        chosen: Columns that were taken, by quantity.
    """
    notes = []
    for quantity, taken in chosen.items():
        if not taken:
            continue
        others = [
            f"{as_one([one.column for one in other])}{_said(other)}"
            for other in _all_of_same_joints(_found(called, quantity), taken)
            if [one.column for one in other] != [one.column for one in taken]
        ]
        if others:
            own = f"{as_one([one.column for one in taken])}{_said(taken)}"
            notes.append(f"taken: {quantity} from {own}, not from {' or '.join(others)}")
    return notes


def _found(called: Mapping[str, str], quantity: Quantity) -> list[list[Named]]:
    if quantity == "tau":
        return [named for kind in TORQUES for named in torques_of(called, kind)]
    return columns_of(called, STEMS[quantity], quantity, SAID)


def _all_of_same_joints(found: Sequence[list[Named]], order: Sequence[Named]) -> list[list[Named]]:
    complete = []
    for named in found:
        by_label = {one.label: one for one in named}
        if all(one.label in by_label for one in order):
            complete.append([by_label[one.label] for one in order])
    return complete


def _said(named: Sequence[Named]) -> str:
    return f" ({named[0].source})" if named[0].source else ""
