"""A table of Denavit-Hartenberg parameters as a robot: a TOML file, written out as a URDF."""

from __future__ import annotations

from collections import Counter
from typing import Literal
from xml.etree import ElementTree

import msgspec
import numpy as np
from pydrake.math import RollPitchYaw, RotationMatrix

from oed.errors import RobotError

ENTRIES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


class DhJoint(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One row of the table; lengths in m, angles in the table's unit.

    Attributes:
        a: Length of the link, along x.
        alpha: Twist of the link, about x.
        d: Offset along the joint axis z; at a prismatic joint, where its position is zero.
        theta: Angle about z; at a revolute joint, where its position is zero.
        name: Of the joint; joint_1 … if empty.
        kind: "revolute" or "prismatic".
        lower: Least position; None where it is not limited.
        upper: Largest position; None where it is not limited.
        velocity: Largest speed; None where it is not limited.
        effort: Largest torque or force [N m or N]; None where it is not limited.
        mass: Of the link [kg].
        com: Its centre of mass in the frame of the row [m].
        inertia: ixx, ixy, ixz, iyy, iyz, izz about the centre of mass, in the axes of that
            frame [kg m^2].
    """

    a: float
    alpha: float
    d: float = 0.0
    theta: float = 0.0
    name: str = ""
    kind: Literal["revolute", "prismatic"] = "revolute"
    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    effort: float | None = None
    mass: float = 0.0
    com: tuple[float, float, float] = (0.0, 0.0, 0.0)
    inertia: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class DhTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A serial arm.

    Attributes:
        convention: "standard" (frame i at the far end of link i: J. Denavit and R. S. Hartenberg
            1955, as in Siciliano) or "modified" (frame i on joint axis i: J. J. Craig 1986).
        joint: The rows, from the base.
        angles: Unit of `alpha`, `theta`, `lower`, `upper` and `velocity`: "rad" or "deg".
        name: Of the robot.
    """

    convention: Literal["standard", "modified"]
    joint: tuple[DhJoint, ...]
    angles: Literal["rad", "deg"] = "rad"
    name: str = ""


def read_dh_table(content: bytes, where: str, name: str) -> ElementTree.Element:
    """The table as the tree of a URDF.

    Args:
        content: Of the file.
        where: Name of the file, for the message.
        name: Of the robot, where the table gives none.

    Raises:
        RobotError: If it is no such table.
    """
    try:
        table = msgspec.toml.decode(content.removeprefix(b"\xef\xbb\xbf"), type=DhTable)
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise RobotError(
            f"{where}: is no table of Denavit-Hartenberg parameters: {error}"
        ) from error
    _check(table, where)
    root = ElementTree.Element("robot", name=table.name or name)
    ElementTree.SubElement(root, "link", name="base")
    # What the rows before leave between the last link's frame and the next joint.
    before = np.eye(4)
    parent = "base"
    turn = np.pi / 180 if table.angles == "deg" else 1.0
    for i, row in enumerate(table.joint):
        along_x = _screw("x", row.a, row.alpha * turn)
        along_z = _screw("z", row.d, row.theta * turn)
        is_standard = table.convention == "standard"
        # Motion along z commutes with along_z. A URDF moves a link after its joint's origin.
        slides = row.kind == "prismatic"
        if is_standard:
            placed, after = before @ along_z, along_x
        else:
            placed, after = before @ along_x @ along_z, np.eye(4)
        link = f"link_{i + 1}"
        joint = _joint(row, _name(row, i), placed, 1.0 if slides else turn)
        ElementTree.SubElement(joint, "parent", link=parent)
        ElementTree.SubElement(joint, "child", link=link)
        root.append(joint)
        _add_link(root, row, link, after)
        before, parent = after, link
    return root


def _check(table: DhTable, where: str) -> None:
    if not table.joint:
        raise RobotError(f"{where}: has no [[joint]] table; write one for each joint")
    names = [_name(row, i) for i, row in enumerate(table.joint)]
    for i, row in enumerate(table.joint):
        limits = (row.lower, row.upper, row.velocity, row.effort)
        numbers = (row.a, row.alpha, row.d, row.theta, row.mass, *row.com, *row.inertia)
        given = [value for value in limits if value is not None]
        if not np.isfinite([*numbers, *given]).all():
            raise RobotError(f"{where}: joint {names[i]!r}: a number is not finite")
        if (row.lower is None) != (row.upper is None):
            raise RobotError(f"{where}: joint {names[i]!r}: give both of lower and upper, or none")
    twice = [name for name, times in Counter(names).items() if times > 1]
    if twice:
        raise RobotError(f"{where}: two joints are called {twice[0]!r}")


def _name(row: DhJoint, i: int) -> str:
    return row.name or f"joint_{i + 1}"


def _screw(axis: Literal["x", "z"], shift: float, angle: float) -> np.ndarray:
    """A turn about an axis and a shift along it."""
    c, s = np.cos(angle), np.sin(angle)
    pose = np.eye(4)
    k = 0 if axis == "x" else 2
    i, j = (k + 1) % 3, (k + 2) % 3
    pose[i, i], pose[i, j], pose[j, i], pose[j, j] = c, -s, s, c
    pose[k, 3] = shift
    return pose


def _origin(pose: np.ndarray) -> dict[str, str]:
    """A pose as a URDF writes it."""
    angles = RollPitchYaw(RotationMatrix(pose[:3, :3])).vector()
    return {"xyz": _text(pose[:3, 3]), "rpy": _text(angles)}


def _text(values) -> str:  # an array or tuple of numbers
    return " ".join(repr(float(value)) for value in values)


def _joint(row: DhJoint, name: str, placed: np.ndarray, unit: float) -> ElementTree.Element:
    """The joint at a place in the link before, its limits in multiples of `unit`."""
    is_limited = row.lower is not None and row.upper is not None
    kind = "continuous" if row.kind == "revolute" and not is_limited else row.kind
    joint = ElementTree.Element("joint", name=name, type=kind)
    ElementTree.SubElement(joint, "origin", _origin(placed))
    ElementTree.SubElement(joint, "axis", xyz="0 0 1")
    limits = {  # 0 stands for no limit
        "lower": (row.lower or 0.0) * unit,
        "upper": (row.upper or 0.0) * unit,
        "velocity": (row.velocity or 0.0) * unit,
        "effort": row.effort or 0.0,
    }
    ElementTree.SubElement(joint, "limit", {key: repr(v) for key, v in limits.items()})
    return joint


def _add_link(root: ElementTree.Element, row: DhJoint, link: str, after: np.ndarray) -> None:
    element = ElementTree.SubElement(root, "link", name=link)
    if not row.mass and not any(row.inertia):
        return
    inertial = ElementTree.SubElement(element, "inertial")
    com = np.eye(4)
    com[:3, 3] = row.com
    ElementTree.SubElement(inertial, "origin", _origin(after @ com))
    ElementTree.SubElement(inertial, "mass", value=repr(row.mass))
    entries = {key: repr(value) for key, value in zip(ENTRIES, row.inertia, strict=True)}
    ElementTree.SubElement(inertial, "inertia", entries)
