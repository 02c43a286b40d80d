"""Numbers of a URDF that are none: Drake reads "0,3" as 0, and the arm as one without that link."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree import ElementTree

import numpy as np

from oed.errors import RobotError

# Of what the model is made of; by element, its attributes and how many numbers each holds.
JOINT_NUMBERS = {
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": {"lower": 1, "upper": 1, "velocity": 1, "effort": 1},
}
LINK_NUMBERS: dict[str, dict[str, int]] = {
    "inertial/origin": {"xyz": 3, "rpy": 3},
    "inertial/mass": {"value": 1},
    "inertial/inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
}


def check_numbers(root: ElementTree.Element, where: str) -> None:
    """Refuse attributes of joints and inertias that are not as many numbers as they must be.

    Args:
        root: Of the URDF.
        where: Name of the file, for the message.

    Raises:
        RobotError: Naming the joint or link, the element, its attribute and what is there.
    """
    for kind, numbers in (("joint", JOINT_NUMBERS), ("link", LINK_NUMBERS)):
        for owner in root.findall(kind):
            for element, key, count, text in _given(owner, numbers):
                if not _holds(text, count):
                    what = "a number" if count == 1 else f"{count} numbers"
                    raise RobotError(
                        f"{where}: {kind} {owner.get('name', '')!r}: {key}={text!r} of "
                        f"<{element.rpartition('/')[2]}> is not {what}{_advice(text)}"
                    )


def _given(
    owner: ElementTree.Element, numbers: dict[str, dict[str, int]]
) -> Iterator[tuple[str, str, int, str]]:
    """Each attribute that is there: its element, name, count of numbers and text."""
    for element, attributes in numbers.items():
        for found in owner.findall(element):
            for key, count in attributes.items():
                text = found.get(key)
                if text is not None:
                    yield element, key, count, text


def _holds(text: str, count: int) -> bool:
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        return False
    return len(values) == count and bool(np.isfinite(values).all())


def _advice(text: str) -> str:
    if "," in text:
        return "; write numbers with a decimal point, and spaces between them"
    return ""
