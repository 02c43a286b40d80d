"""Joints that follow another, as the fingers of a gripper do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from oed.errors import RobotError


@dataclass(frozen=True)
class Mimic:
    """How a joint follows another: its position is multiplier times that of the leader + offset.

    Attributes:
        leader: Name of the joint that it follows.
        multiplier: Of the leader's position.
        offset: Its position where the leader is at zero [rad or m].
    """

    leader: str
    multiplier: float = 1.0
    offset: float = 0.0


def read_mimics(
    root: ElementTree.Element, file_format: str, where: str
) -> tuple[dict[str, Mimic], tuple[str, ...]]:
    """The followers of a file by name, and notes on those that follow nobody.

    Args:
        root: Of the file; what follows no joint that moves loses its element in place.
        file_format: "urdf", "sdf" or "mjcf".
        where: Name of the file, for the message.

    Raises:
        RobotError: If joints follow one another in a circle.
    """
    found = _of_mjcf(root) if file_format == "mjcf" else _of_elements(root, file_format)
    names = {joint.get("name") for joint in root.iter("joint")}
    rigid = {j.get("name") for j in root.iter("joint") if j.get("type") == "fixed"}
    notes = []
    for follower, mimic in list(found.items()):
        if follower in rigid or mimic.leader in rigid:  # Drake refuses a file with such
            _remove(root, follower)
        if mimic.leader not in names:
            del found[follower]
            _remove(root, follower)
            notes.append(
                f"joint {follower!r} mimics {mimic.leader!r}, which the file does not have: it is "
                "taken as a joint of its own"
            )
    for follower in found:
        seen = [follower]
        while seen[-1] in found:
            leader = found[seen[-1]].leader
            if leader in seen:
                raise RobotError(f"{where}: joint {follower!r} mimics itself, by {leader!r}")
            seen.append(leader)
    return found, tuple(notes)


def held_position(name: str, mimics: Mapping[str, Mimic], locked: Mapping[str, float]) -> float:
    """Where a joint that is not active stands [rad or m].

    Args:
        name: Of the joint.
        mimics: Followers by name.
        locked: Positions that were given; others are zero, or follow from their leader's.
    """
    if name in locked or name not in mimics:
        return float(locked.get(name, 0.0))
    mimic = mimics[name]
    return mimic.offset + mimic.multiplier * held_position(mimic.leader, mimics, locked)


def _of_elements(root: ElementTree.Element, file_format: str) -> dict[str, Mimic]:
    """<mimic> of a URDF's joints, or of the axes of an SDF's."""
    path = "mimic" if file_format == "urdf" else "axis/mimic"
    found = {}
    for joint in root.iter("joint"):
        mimic = joint.find(path)
        if mimic is not None:
            values = [
                _number(mimic.get(key) if file_format == "urdf" else mimic.findtext(key), default)
                for key, default in (("multiplier", 1.0), ("offset", 0.0))
            ]
            found[joint.get("name", "")] = Mimic(mimic.get("joint", ""), *values)
    return found


def _of_mjcf(root: ElementTree.Element) -> dict[str, Mimic]:
    """Equalities of two joints: the first is a polynomial of the second."""
    found = {}
    for equality in root.iterfind("equality/joint"):
        second = equality.get("joint2")
        if second and equality.get("active", "true") != "false":
            terms = [_number(word, 0.0) for word in equality.get("polycoef", "0 1").split()]
            offset, slope = (*terms, 0.0, 0.0)[:2]
            found[equality.get("joint1", "")] = Mimic(second, slope, offset)
    return found


def _remove(root: ElementTree.Element, follower: str) -> None:
    for joint in root.iter("joint"):
        if joint.get("name") == follower:
            for owner in (joint, *joint.findall("axis")):
                for element in owner.findall("mimic"):
                    owner.remove(element)
    for equalities in root.findall("equality"):
        for element in equalities.findall("joint"):
            if element.get("joint1") == follower:
                equalities.remove(element)


def _number(text: str | None, otherwise: float) -> float:
    try:
        value = float(text) if text is not None else otherwise
    except ValueError:
        return otherwise
    return value if np.isfinite(value) else otherwise
