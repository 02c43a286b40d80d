"""Inertias that no body has, found in a robot's file and replaced there.

What takes their place is what Drake takes: a ball of water of the same mass about the same centre.
Every program is then given the file with the ball in it, so that all compute the same robot.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from jaxtyping import Float
from numpy import ndarray

# Relative: files round their numbers, and thin plates lie on the edge of what is possible.
TRIANGLE_TOLERANCE = 1e-6
WATER = 1000.0  # [kg/m^3]
ENTRIES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


@dataclass(frozen=True)
class InertiaFault:
    """A link whose inertia in the robot's file is that of no body.

    Attributes:
        link: Its name.
        text: What is wrong, in one line.
        has_mass: Whether at least its mass is positive.
    """

    link: str
    text: str
    has_mass: bool

    @property
    def replacement(self) -> str:
        """What is wrong, and what was taken in its place."""
        if self.has_mass:
            return f"{self.text}; a ball of the same mass was taken in its place"
        return f"{self.text}; the link is taken as without mass"


def replace_impossible(root: ElementTree.Element, file_format: str) -> dict[str, InertiaFault]:
    """Put a ball in the place of every inertia that no body has, and nothing for no mass.

    Args:
        root: Of the file; its inertias are edited in place.
        file_format: "urdf", "sdf" or "mjcf".

    Returns:
        What was wrong, by link.
    """
    faults = {}
    for link in root.iter("body" if file_format == "mjcf" else "link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        name = link.get("name", "")
        mass, inertia = READERS[file_format](inertial)
        fault = _fault(name, mass, inertia)
        if fault is None:
            continue
        faults[name] = fault
        if fault.has_mass:
            WRITERS[file_format](inertial, ball_inertia(mass))
        else:
            link.remove(inertial)
    return faults


def ball_inertia(mass: float) -> float:
    """Moment of inertia of a ball of water about any axis through its centre [kg m^2]."""
    radius = np.cbrt(3 * mass / (4 * np.pi * WATER))
    return 0.4 * mass * float(radius) ** 2


def _fault(name: str, mass: float, inertia: Float[ndarray, "3 3"] | None) -> InertiaFault | None:
    given = inertia is not None and bool(np.any(inertia))
    if mass < 0 or (mass == 0 and given):
        what = f"link {name!r} has a mass of {mass:g} kg"
        return InertiaFault(name, what if mass else f"{what} but an inertia", has_mass=False)
    if inertia is None:
        return None
    moments = np.linalg.eigvalsh(inertia)
    slack = TRIANGLE_TOLERANCE * np.abs(moments).max()
    if moments[0] < -slack or moments[0] + moments[1] < moments[2] - slack:
        shown = ", ".join(f"{moment:.3g}" for moment in moments)
        what = f"link {name!r}: no body has principal moments of inertia {shown} kg m^2"
        return InertiaFault(name, what, has_mass=True)
    return None


Read = tuple[float, Float[ndarray, "3 3"] | None]


def _read_urdf(inertial: ElementTree.Element) -> Read:
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    value = 0.0 if mass is None else _number(mass.get("value"))
    entries = [0.0 if inertia is None else _number(inertia.get(key)) for key in ENTRIES]
    return value, _symmetric(entries)


def _write_urdf(inertial: ElementTree.Element, moment: float) -> None:
    inertia = inertial.find("inertia")
    if inertia is not None:
        inertia.attrib.update({key: _entry(key, moment) for key in ENTRIES})


def _read_sdf(inertial: ElementTree.Element) -> Read:
    mass = inertial.findtext("mass")
    inertia = inertial.find("inertia")
    if mass is None or inertia is None:  # 1 kg, or moments of 1 kg m^2, or computed from shapes
        return 1.0, None
    entries = [_number(inertia.findtext(key), 1.0 if key[1] == key[2] else 0.0) for key in ENTRIES]
    return _number(mass), _symmetric(entries)


def _write_sdf(inertial: ElementTree.Element, moment: float) -> None:
    inertia = inertial.find("inertia")
    if inertia is None:
        return
    for key in ENTRIES:
        element = inertia.find(key)
        element = ElementTree.SubElement(inertia, key) if element is None else element
        element.text = _entry(key, moment)


def _read_mjcf(inertial: ElementTree.Element) -> Read:
    mass = _number(inertial.get("mass"))
    full, diagonal = inertial.get("fullinertia"), inertial.get("diaginertia")
    values = [_number(word) for word in (full or diagonal or "").split()]
    if full is not None and len(values) == 6:
        xx, yy, zz, xy, xz, yz = values
        return mass, _symmetric([xx, xy, xz, yy, yz, zz])
    if diagonal is not None and len(values) == 3:
        return mass, np.diag(values)
    return mass, None


def _write_mjcf(inertial: ElementTree.Element, moment: float) -> None:
    inertial.attrib.pop("fullinertia", None)
    inertial.set("diaginertia", " ".join([repr(moment)] * 3))


def _symmetric(entries: list[float]) -> Float[ndarray, "3 3"]:
    xx, xy, xz, yy, yz, zz = entries
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _entry(key: str, moment: float) -> str:
    return repr(moment) if key[1] == key[2] else "0"


def _number(text: str | None, otherwise: float = 0.0) -> float:
    """Text as a number; `otherwise` where it is missing, or no number, as Drake will say."""
    try:
        value = float(text) if text is not None else otherwise
    except ValueError:
        return otherwise
    return value if np.isfinite(value) else otherwise


READERS: dict[str, Callable[[ElementTree.Element], Read]] = {
    "urdf": _read_urdf,
    "sdf": _read_sdf,
    "mjcf": _read_mjcf,
}
WRITERS: dict[str, Callable[[ElementTree.Element, float], None]] = {
    "urdf": _write_urdf,
    "sdf": _write_sdf,
    "mjcf": _write_mjcf,
}
