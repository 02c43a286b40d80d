"""Which name in a log is which joint of the robot."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence

# What loggers put behind a motor's name.
ENDINGS = re.compile(r"[._/ ](pos|position|angle|q|vel|velocity|speed|effort|torque|current)$")


def match_joints(labels: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """The log's name of each joint of the robot that can be told without doubt.

    Args:
        labels: Names in the log.
        joints: Names in the robot's file.

    Returns:
        Names in the log by joint, in the order of `joints`; empty if none can be told.
    """
    for rule in (_same, _same_core, _contained, _same_numbers):
        found = rule(labels, joints)
        if found:
            return {joint: found[joint] for joint in joints if joint in found}
    return {}


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", ENDINGS.sub("", name.strip().lower())).strip("_")


def _same(labels: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """Names that are the same but for case, signs between words and a logger's ending."""
    plain = {_plain(label): label for label in labels}
    if len(plain) < len(labels):
        return {}
    return {joint: plain[_plain(joint)] for joint in joints if _plain(joint) in plain}


def _same_core(labels: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """All names are the same without what those of the log, or of the robot, have in common."""
    if len(labels) != len(joints) or len(labels) < 2:
        return {}
    mine, theirs = _cores(labels), _cores(joints)
    if len(set(mine)) < len(mine) or set(mine) != set(theirs):
        return {}
    return {joint: labels[mine.index(core)] for joint, core in zip(joints, theirs, strict=True)}


def _cores(names: Sequence[str]) -> list[str]:
    plain = [_plain(name) for name in names]
    start = common_start(plain)
    end = common_start([name[start:][::-1] for name in plain])
    return [name[start : len(name) - end].strip("_") for name in plain]


def common_start(words: Sequence[str]) -> int:
    """How many letters all words begin with."""
    columns = itertools.takewhile(lambda letters: len(set(letters)) == 1, zip(*words, strict=False))
    return sum(1 for _ in columns)


def _contained(labels: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """Each name in the log is a part of one joint's name, or the reverse, and of no other."""
    found: dict[str, str] = {}
    for label in labels:
        word = _plain(label)
        hits = [joint for joint in joints if word in _plain(joint) or _plain(joint) in word]
        if len(hits) != 1 or hits[0] in found:
            return {}
        found[hits[0]] = label
    return found


def _same_numbers(labels: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """Names with the same numbers in them, such as fer_joint1 for panda_joint1.

    Of several families of names in one file (an arm and its fingers), those with the most members
    belong together.
    """
    mine, theirs = _largest_family(labels), _largest_family(joints)
    if len(mine) < 2 or set(mine) != set(theirs):
        return {}
    return {theirs[number]: mine[number] for number in theirs}


def _largest_family(names: Sequence[str]) -> dict[tuple[int, ...], str]:
    families: dict[str, dict[tuple[int, ...], str]] = {}
    for name in names:
        pattern = re.sub(r"\d+", "#", _plain(name))
        number = tuple(int(digits) for digits in re.findall(r"\d+", _plain(name)))
        if number:
            families.setdefault(pattern, {})[number] = name
    sizes = sorted((len(family) for family in families.values()), reverse=True)
    if not sizes or sizes[:2].count(sizes[0]) > 1:
        return {}
    return max(families.values(), key=len)
