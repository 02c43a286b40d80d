"""Which joint of the robot each column of positions is of."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from oed.counted import as_one, counted, listed
from oed.errors import DataSetError
from oed.experiment.importing.joint_names import match_joints
from oed.experiment.importing.layouts import Named
from oed.experiment.importing.name_words import joint_number
from oed.experiment.logs.table import Table


@dataclass(frozen=True)
class RobotJoints:
    """What joints a data set may be of.

    Attributes:
        movable: All that move, from the base outward.
        arm: Those of the arm proper, without the fingers of a gripper.
        chosen: Those that the user named, in the order of the log's columns; empty if none.
    """

    movable: tuple[str, ...]
    arm: tuple[str, ...]
    chosen: tuple[str, ...] = ()


def assign_joints(
    positions: list[Named], joints: RobotJoints, table: Table
) -> tuple[list[Named], tuple[str, ...]]:
    """Positions in the order of the robot's joints, and the names of these.

    Raises:
        DataSetError: If they are of no joints that can be told.
    """
    numbered = [one for one in positions if one.label.isdigit() or not one.label]
    if not numbered and not _matched(positions, joints):
        numbered = positions if _differ_by_number(positions) else []
    if numbered:
        order = sorted(numbered, key=lambda one: _number(one.label))
        if len({_number(one.label) for one in order}) < len(order):
            raise _more_than_once(order, table)
        for names in (joints.chosen,) if joints.chosen else (joints.arm, joints.movable):
            if len(names) == len(order):
                return order, names
        message = (
            f"holds positions of {counted(len(order), 'joint')} ({listed([one.column for one in order])}), the "
            f"robot has {len(joints.arm)} in its arm and {len(joints.movable)} in all"
            f"{f', --joints names {len(joints.chosen)}' if joints.chosen else ''}; say "
            f"{_which(len(order), joints)}"
        )
        raise DataSetError(message, file=table.file)
    labels = {one.label: one for one in positions}
    found = _matched(positions, joints)
    if found:
        mine = [one for one in positions if one.label in found.values()]
        if len(mine) > len(found):
            raise _more_than_once(mine, table)
        return [labels[label] for label in found.values()], tuple(found)
    if len(joints.chosen) == len(positions):
        return positions, joints.chosen
    message = (
        f"joints are named {listed(list(labels))} in the log, {listed(joints.movable)} in the robot's "
        f"file; name the file of the robot that was logged with --robot, or, if it is this one, say "
        f"{_which(len(labels), joints)}"
    )
    raise DataSetError(message, file=table.file)


def _differ_by_number(positions: Sequence[Named]) -> bool:
    """Whether joints are told by nothing but a number, as in J1 or, alike in all, 1_a."""
    labels = {one.label for one in positions}
    alike = {re.sub(r"\d+", "#", label) for label in labels}
    is_one_number = len(alike) == 1 and alike.pop().count("#") == 1
    return is_one_number or all(joint_number(label) is not None for label in labels)


def _number(label: str) -> int:
    digits = re.search(r"\d+", label)
    return 0 if digits is None else int(digits[0])


def _matched(positions: Sequence[Named], joints: RobotJoints) -> dict[str, str]:
    """The label of each joint where the names of all tell which is which, else none."""
    labels = list(dict.fromkeys(one.label for one in positions))
    for names in (joints.chosen or joints.arm, joints.chosen or joints.movable):
        found = match_joints(labels, names)
        if found and (len(found) == len(names) or len(found) == len(labels)):
            return found
    return {}


def _more_than_once(positions: Sequence[Named], table: Table) -> DataSetError:
    message = (
        f"holds positions of one joint more than once ({listed(places(positions))}); say which are of the "
        "robot, as in --columns q=NAME,NAME"
    )
    return DataSetError(message, file=table.file)


def _which(logged: int, joints: RobotJoints) -> str:
    """What to say of joints of which it cannot be told which of the robot's they are."""
    columns = "which columns are of the robot, as in --columns q=NAME,NAME"
    if logged > len(joints.movable):
        return columns
    names = "which they are with --joints, by the robot's names in the order of the log"
    return f"{names}, or {columns}" if logged > len(joints.chosen or joints.arm) else names


def places(columns: Sequence[Named]) -> list[str]:
    """The columns in few words, those that are of the same arm together."""
    groups: dict[frozenset[str], list[str]] = {}
    for one in columns:
        groups.setdefault(one.whose, []).append(one.column)
    return [as_one(names) for names in groups.values()]
