"""URDF: the source file with its inertials and joint dynamics replaced, or a file anew."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from oed.errors import RobotError
from oed.export.calibrated_robot import CalibratedRobot, link_inertial
from oed.export.own_name import own_name
from oed.export.shapes import MESHES, Shapes
from oed.export.xml_text import number, numbers, roll_pitch_yaw, write_xml
from oed.robot.description import RobotDescription
from oed.robot.xml_tree import parse_xml

DRAKE = "https://drake.mit.edu/"
# Drake reads no actuator, and so no rotor inertia, where a joint may not push at all.
ANY_EFFORT = 1e9  # [N m or N]
NO_SHAPES = Shapes()


def write_urdf(
    calibrated: CalibratedRobot,
    path: str | Path,
    *,
    home: Path | None = None,
    shapes: Shapes = NO_SHAPES,
) -> Path:
    """Write a robot as URDF.

    A robot that came from a URDF file keeps all else that is in it: visuals, collision geometry,
    limits. What was merged into a link when it was identified loses its own inertial,
    and joints that were held become fixed where they were held.

    Args:
        calibrated: To write.
        path: Of the new file.
        home: Folder from which its meshes are to be found, where it is moved there afterwards;
            the file's own if None.
        shapes: Of its bodies, where it is written anew.

    Returns:
        The path.
    """
    path = Path(path)
    file = calibrated.robot.description
    ElementTree.register_namespace("drake", DRAKE)
    if file is not None and file.format == "urdf":
        root = _edited(calibrated, file, home or path.parent)
    else:
        root = _generated(calibrated, shapes)
    _set_joints(calibrated, root)
    write_xml(path, root)
    return path


def _edited(
    calibrated: CalibratedRobot, file: RobotDescription, folder: Path
) -> ElementTree.Element:
    robot = calibrated.robot
    root = parse_xml(file.text.encode(), str(file.path)).root
    column = {joint.name: i for i, joint in enumerate(robot.joints)}
    for joint in root.findall("joint"):
        if joint.get("name") in robot.held:
            _fix(joint, robot.held[joint.get("name", "")])
    links = {link.get("name"): link for link in root.findall("link")}
    for name, carrier in _carriers(root, column).items():
        if carrier is None:
            continue
        for old in links[name].findall("inertial"):
            links[name].remove(old)
        if name == robot.joints[carrier].link:
            _add_inertial(links[name], calibrated, carrier, in_source_link=True)
    for mesh in root.iter("mesh"):
        _keep_reachable(mesh, file.place.parent, folder)
    return root


def _fix(joint: ElementTree.Element, position: float) -> None:
    """Make a joint fixed at a position [rad or m]: its origin takes the motion up to there."""
    axis = joint.find("axis")
    words = "1 0 0" if axis is None else axis.get("xyz", "1 0 0")
    direction = np.array([float(word) for word in words.split()])
    direction /= np.linalg.norm(direction)
    origin = joint.find("origin")
    if position and origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    if position and origin is not None:
        xyz, rpy = (
            np.array([float(word) for word in origin.get(key, "0 0 0").split()])
            for key in ("xyz", "rpy")
        )
        turned = Rotation.from_euler("xyz", rpy)  # about fixed axes
        if joint.get("type") == "prismatic":
            origin.set("xyz", numbers(xyz + turned.apply(position * direction)))
        else:
            turn = Rotation.from_rotvec(position * direction)
            origin.set("rpy", roll_pitch_yaw((turned * turn).as_matrix()))
    joint.set("type", "fixed")
    for mimic in joint.findall("mimic"):
        joint.remove(mimic)


def _carriers(root: ElementTree.Element, column: Mapping[str, int]) -> dict[str, int | None]:
    """For every link the active joint that carries it, None where it stands still."""
    above = {}
    for joint in root.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            above[child.get("link", "")] = (joint.get("name", ""), parent.get("link", ""))
    found: dict[str, int | None] = {}
    for link in root.findall("link"):
        name = start = link.get("name", "")
        found[start] = None
        while name in above:
            joint_name, name = above[name]
            if joint_name in column:
                found[start] = column[joint_name]
                break
    return found


def _keep_reachable(mesh: ElementTree.Element, old: Path, new: Path) -> None:
    filename = mesh.get("filename", "")
    if filename and "://" not in filename and not Path(filename).is_absolute():
        mesh.set("filename", os.path.relpath(old / filename, new))


def _generated(calibrated: CalibratedRobot, shapes: Shapes) -> ElementTree.Element:
    robot = calibrated.robot
    root = ElementTree.Element("robot", name=own_name(robot))
    _add_shapes(ElementTree.SubElement(root, "link", name="base"), shapes, -1)
    for i in robot.outward:
        joint = robot.joints[i]
        element = ElementTree.SubElement(root, "joint", name=joint.name, type=joint.kind)
        parent = "base" if joint.parent == -1 else robot.joints[joint.parent].link
        ElementTree.SubElement(element, "parent", link=parent)
        ElementTree.SubElement(element, "child", link=joint.link)
        pose = {"xyz": numbers(joint.p_PJ), "rpy": roll_pitch_yaw(joint.R_PJ)}
        ElementTree.SubElement(element, "origin", pose)
        ElementTree.SubElement(element, "axis", xyz=numbers(joint.axis))
        _add_limit(element, calibrated, i)
        link = ElementTree.SubElement(root, "link", name=joint.link)
        _add_inertial(link, calibrated, i, in_source_link=False)
        _add_shapes(link, shapes, i)
    return root


def _add_shapes(link: ElementTree.Element, shapes: Shapes, joint: int) -> None:
    for shape in shapes.of(joint):
        element = ElementTree.SubElement(
            link, "collision" if shape.is_collision else "visual", name=shape.name
        )
        pose = {"xyz": numbers(shape.p), "rpy": roll_pitch_yaw(shape.R)}
        ElementTree.SubElement(element, "origin", pose)
        form = ElementTree.SubElement(ElementTree.SubElement(element, "geometry"), shape.kind)
        if shape.kind == "mesh":
            form.set("filename", f"{MESHES}/{shape.mesh}")
            form.set("scale", numbers(shape.size))
        elif shape.kind == "box":
            form.set("size", numbers(shape.size))
        else:
            for name, value in zip(("radius", "length"), shape.size, strict=False):
                form.set(name, number(value))
        if shape.colour is not None and not shape.is_collision:
            material = ElementTree.SubElement(element, "material", name=f"{shape.name}_colour")
            ElementTree.SubElement(material, "color", rgba=numbers(shape.colour))


def _add_limit(element: ElementTree.Element, calibrated: CalibratedRobot, i: int) -> None:
    limits = calibrated.robot.limits
    lower, upper = limits.position[i]
    if not np.isfinite([lower, upper]).all():
        if element.get("type") == "revolute":
            element.set("type", "continuous")
        lower, upper = -ANY_EFFORT, ANY_EFFORT
    effort, velocity = limits.torque[i, 1], limits.velocity[i, 1]
    ElementTree.SubElement(
        element,
        "limit",
        lower=number(lower),
        upper=number(upper),
        effort=number(effort if np.isfinite(effort) else ANY_EFFORT),
        velocity=number(velocity if np.isfinite(velocity) else ANY_EFFORT),
    )


def _add_inertial(
    link: ElementTree.Element, calibrated: CalibratedRobot, i: int, *, in_source_link: bool
) -> None:
    body = link_inertial(calibrated.robot, i, in_source_link=in_source_link)
    inertial = ElementTree.Element("inertial")
    ElementTree.SubElement(inertial, "origin", xyz=numbers(body.com), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=number(body.mass))
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    values = body.inertia[np.triu_indices(3)]
    entries = {name: number(value) for name, value in zip(names, values, strict=True)}
    ElementTree.SubElement(inertial, "inertia", entries)
    link.insert(0, inertial)


def _set_joints(calibrated: CalibratedRobot, root: ElementTree.Element) -> None:
    elements = {joint.get("name"): joint for joint in root.findall("joint")}
    for i, name in enumerate(calibrated.robot.joint_names):
        joint = elements.get(name)
        if joint is None:
            raise RobotError(f"{calibrated.robot.source}: no joint {name!r}, which the model has")
        for old in joint.findall("dynamics"):
            joint.remove(old)
        ElementTree.SubElement(
            joint,
            "dynamics",
            damping=number(calibrated.viscous[i]),
            friction=number(calibrated.coulomb[i]),
        )
        if calibrated.rotor_inertia[i] > 0:
            _set_rotor(root, joint, name, float(calibrated.rotor_inertia[i]))


def _set_rotor(
    root: ElementTree.Element, joint: ElementTree.Element, name: str, inertia: float
) -> None:
    limit = joint.find("limit")
    if limit is not None and float(limit.get("effort", "0")) == 0.0:
        limit.set("effort", number(ANY_EFFORT))
    for old in root.findall("transmission"):
        moved = old.find("joint")
        if moved is not None and moved.get("name") == name:
            root.remove(old)
    transmission = ElementTree.SubElement(root, "transmission", name=f"{name}_transmission")
    kind = ElementTree.SubElement(transmission, "type")
    kind.text = "transmission_interface/SimpleTransmission"
    ElementTree.SubElement(transmission, "joint", name=name)
    actuator = ElementTree.SubElement(transmission, "actuator", name=name)
    ElementTree.SubElement(actuator, f"{{{DRAKE}}}rotor_inertia", value=number(inertia))
    ElementTree.SubElement(actuator, f"{{{DRAKE}}}gear_ratio", value="1")
