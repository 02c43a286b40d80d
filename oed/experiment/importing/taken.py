"""Which columns were taken where several are of one quantity of the same joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from oed.counted import as_one
from oed.experiment.importing.layouts import (
    STEMS,
    TORQUES,
    Named,
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
        mine = [next((one for one in named if _is_of(one, joint)), None) for joint in order]
        if None not in mine:
            complete.append([one for one in mine if one is not None])
    return complete


def _is_of(one: Named, position: Named) -> bool:
    """Whether a column is of the joint of a position, of the same arm as far as the names tell.

    A position that the user named may have words of its own.
    """
    is_same = one.whose == position.whose or (not position.stem and one.whose < position.whose)
    return is_same and one.label == position.label


def _said(named: Sequence[Named]) -> str:
    return f" ({named[0].source})" if named[0].source else ""
