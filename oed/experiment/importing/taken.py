"""Which columns were taken where several are of one quantity of the same joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from oed.counted import as_one
from oed.experiment.importing.layouts import MEASURED, Named, columns_of, torques_of
from oed.experiment.importing.name_words import joint_number
from oed.experiment.importing.quantity_names import STEMS, TORQUES
from oed.experiment.units import Quantity


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
    return columns_of(called, STEMS[quantity], quantity, (*MEASURED, "commanded"))


def _all_of_same_joints(found: Sequence[list[Named]], order: Sequence[Named]) -> list[list[Named]]:
    complete = []
    for named in found:
        mine = [_of_joint(named, joint) for joint in order]
        if None not in mine:
            complete.append([one for one in mine if one is not None])
    return complete


def _of_joint(named: Sequence[Named], position: Named) -> Named | None:
    """The column of the joint of a position, of the same arm as far as the names tell.

    A position that the user named may have words of its own.
    """
    own = [
        one
        for one in named
        if one.whose == position.whose or (not position.stem and one.whose < position.whose)
    ]
    number = joint_number(position.label)
    same = [one for one in own if one.label == position.label] or [
        one for one in own if number is not None and joint_number(one.label) == number
    ]
    return same[0] if same else None


def _said(named: Sequence[Named]) -> str:
    return f" ({named[0].source})" if named[0].source else ""
