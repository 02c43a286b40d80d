"""What a URDF says that Drake aborts on, passes over or replaces with something of its own."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from oed.errors import RobotError


def read_efforts(root: ElementTree.Element, where: str) -> dict[str, float]:
    """Largest torque or force of each joint that has a limit, by name [N m or N].

    Raises:
        RobotError: If a joint's limit contradicts itself.
    """
    efforts = {}
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        if limit is not None:
            name = joint.get("name", "")
            _check_limit(limit, where, name)
            largest = _number(limit, "effort")
            if largest is not None:
                efforts[name] = largest
    return efforts


def _check_limit(limit: ElementTree.Element, where: str, name: str) -> None:
    """Refuse a limit that contradicts itself; a bound that is left out is zero."""
    lower, upper = _number(limit, "lower") or 0.0, _number(limit, "upper") or 0.0
    if lower > upper:
        raise RobotError(
            f"{where}: joint {name!r}: lower limit {lower:g} is above upper limit "
            f"{upper:g}; exchange or correct them"
        )
    for kind in ("velocity", "effort"):
        value = _number(limit, kind)
        if value is not None and value < 0:
            raise RobotError(
                f"{where}: joint {name!r}: {kind} limit {value:g} is negative; a limit is a "
                "magnitude, 0 where none is known"
            )


def _number(element: ElementTree.Element, key: str) -> float | None:
    """An attribute as a number; None where it is missing, or no number, as Drake will say."""
    try:
        value = float(element.get(key, "nan"))
    except ValueError:
        return None
    return value if np.isfinite(value) else None
