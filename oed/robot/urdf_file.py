"""What a URDF says that Drake aborts on, passes over or replaces with something of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from oed.errors import RobotError
from oed.robot.robot import InertiaFault
from oed.robot.urdf_numbers import check_numbers

# Relative: files round their numbers, and thin plates lie on the edge of what is possible.
TRIANGLE_TOLERANCE = 1e-6


@dataclass(frozen=True)
class UrdfFacts:
    """What is taken from the file's text.

    Attributes:
        effort: Largest torque of each joint that has a limit [N m or N].
        mimics: For each joint that follows another, that other.
        faults: By link, what is wrong with its inertia.
    """

    effort: Mapping[str, float] = field(default_factory=dict)
    mimics: Mapping[str, str] = field(default_factory=dict)
    faults: Mapping[str, InertiaFault] = field(default_factory=dict)


def read_urdf(path: Path) -> UrdfFacts:
    """Read a URDF's text; of other files, and absent ones, nothing is known.

    Raises:
        RobotError: If it is no XML, holds text for numbers, or a joint's limit contradicts itself.
    """
    if path.suffix.lower() != ".urdf" or not path.is_file():
        return UrdfFacts()
    try:
        root = ElementTree.fromstring(path.read_bytes())  # noqa: S314  # the user's own robot file
    except ElementTree.ParseError as error:
        raise RobotError(f"{path}: cannot read this file as XML: {error}") from error
    check_numbers(root, path)
    effort, mimics, faults = {}, {}, {}
    for joint in root.findall("joint"):
        name = joint.get("name", "")
        limit = joint.find("limit")
        if limit is not None:
            _check_limit(limit, path, name)
            largest = _number(limit, "effort")
            if largest is not None:
                effort[name] = largest
        leader = joint.find("mimic")
        if leader is not None:
            mimics[name] = leader.get("joint", "")
    for link in root.findall("link"):
        fault = _inertia_fault(link)
        if fault is not None:
            faults[link.get("name", "")] = fault
    return UrdfFacts(effort, mimics, faults)


def _check_limit(limit: ElementTree.Element, path: Path, name: str) -> None:
    """Refuse a limit that contradicts itself; a bound that is left out is zero."""
    lower, upper = _number(limit, "lower") or 0.0, _number(limit, "upper") or 0.0
    if lower > upper:
        raise RobotError(
            f"{path}: joint {name!r}: lower limit {lower:g} is above upper limit "
            f"{upper:g}; exchange or correct them"
        )
    for kind in ("velocity", "effort"):
        value = _number(limit, kind)
        if value is not None and value < 0:
            raise RobotError(
                f"{path}: joint {name!r}: {kind} limit {value:g} is negative; a limit is a "
                "magnitude, 0 where none is known"
            )


def _inertia_fault(link: ElementTree.Element) -> InertiaFault | None:
    inertial = link.find("inertial")
    if inertial is None:
        return None
    mass_element, inertia = inertial.find("mass"), inertial.find("inertia")
    mass = None if mass_element is None else _number(mass_element, "value")
    mass = 0.0 if mass is None else mass
    entries = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    given = [0.0 if inertia is None else _number(inertia, key) or 0.0 for key in entries]
    name = link.get("name", "")
    if mass < 0 or (mass == 0 and any(given)):
        what = f"link {name!r} has a mass of {mass:g} kg"
        return InertiaFault(name, what if mass else f"{what} but an inertia", has_mass=False)
    xx, xy, xz, yy, yz, zz = given
    moments = np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    slack = TRIANGLE_TOLERANCE * np.abs(moments).max()
    if moments[0] < -slack or moments[0] + moments[1] < moments[2] - slack:
        shown = ", ".join(f"{moment:.3g}" for moment in moments)
        what = f"link {name!r}: no body has principal moments of inertia {shown} kg m^2"
        return InertiaFault(name, what, has_mass=True)
    return None


def _number(element: ElementTree.Element, key: str) -> float | None:
    """An attribute as a number; None where it is missing, or no number, as Drake will say."""
    try:
        value = float(element.get(key, "nan"))
    except ValueError:
        return None
    return value if np.isfinite(value) else None
