"""SDF 1.9, written anew from the robot's tree: link frames are joint frames."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.export.calibrated_robot import CalibratedRobot, link_inertial
from oed.export.own_name import own_name
from oed.export.shapes import MESHES, Shapes
from oed.export.xml_text import number, numbers, quaternion, write_xml

DRAKE = "https://drake.mit.edu/"
NO_SHAPES = Shapes()
WHOLE = {"box": "size", "ellipsoid": "radii"}  # shapes whose sizes stand in one element


def write_sdf(calibrated: CalibratedRobot, path: str | Path, *, shapes: Shapes = NO_SHAPES) -> Path:
    """Write a robot as SDF.

    Args:
        calibrated: To write.
        path: Of the new file.
        shapes: Of its bodies.

    Returns:
        The path.
    """
    robot = calibrated.robot
    ElementTree.register_namespace("drake", DRAKE)
    root = ElementTree.Element("sdf", version="1.9")
    model = ElementTree.SubElement(root, "model", name=own_name(robot))
    base = ElementTree.SubElement(model, "joint", name="base_weld", type="fixed")
    _add_text(base, "parent", "world")
    _add_text(base, "child", "base")
    _add_shapes(ElementTree.SubElement(model, "link", name="base"), shapes, -1)
    for i in robot.outward:
        joint = robot.joints[i]
        parent = "base" if joint.parent == -1 else robot.joints[joint.parent].link
        _add_joint(model, calibrated, i, parent)
        link = ElementTree.SubElement(model, "link", name=joint.link)
        _add_text(link, "pose", "0 0 0 0 0 0").set("relative_to", joint.name)
        _add_inertial(link, calibrated, i)
        _add_shapes(link, shapes, i)
    path = Path(path)
    write_xml(path, root)
    return path


def _add_joint(
    model: ElementTree.Element, calibrated: CalibratedRobot, i: int, parent: str
) -> None:
    joint, limits = calibrated.robot.joints[i], calibrated.robot.limits
    element = ElementTree.SubElement(model, "joint", name=joint.name, type=joint.kind)
    pose = _add_text(element, "pose", _pose(joint.R_PJ, joint.p_PJ))
    pose.set("relative_to", parent)
    pose.set("rotation_format", "quat_xyzw")
    _add_text(element, "parent", parent)
    _add_text(element, "child", joint.link)
    axis = ElementTree.SubElement(element, "axis")
    _add_text(axis, "xyz", numbers(joint.axis))
    limit = ElementTree.SubElement(axis, "limit")
    for name, bounds, side in (
        ("lower", limits.position, 0),
        ("upper", limits.position, 1),
        ("effort", limits.torque, 1),
        ("velocity", limits.velocity, 1),
    ):
        if np.isfinite(bounds[i, side]):
            _add_text(limit, name, number(bounds[i, side]))
    dynamics = ElementTree.SubElement(axis, "dynamics")
    _add_text(dynamics, "damping", number(calibrated.viscous[i]))
    _add_text(dynamics, "friction", number(calibrated.coulomb[i]))
    if calibrated.rotor_inertia[i] > 0:
        _add_text(element, f"{{{DRAKE}}}rotor_inertia", number(calibrated.rotor_inertia[i]))
        _add_text(element, f"{{{DRAKE}}}gear_ratio", "1")


def _add_inertial(link: ElementTree.Element, calibrated: CalibratedRobot, i: int) -> None:
    body = link_inertial(calibrated.robot, i, in_source_link=False)
    inertial = ElementTree.SubElement(link, "inertial")
    _add_text(inertial, "pose", numbers((*body.com, 0.0, 0.0, 0.0)))
    _add_text(inertial, "mass", number(body.mass))
    inertia = ElementTree.SubElement(inertial, "inertia")
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    for name, value in zip(names, body.inertia[np.triu_indices(3)], strict=True):
        _add_text(inertia, name, number(value))


def _add_shapes(link: ElementTree.Element, shapes: Shapes, joint: int) -> None:
    for shape in shapes.of(joint):
        kind = "collision" if shape.is_collision else "visual"
        element = ElementTree.SubElement(link, kind, name=shape.name)
        _add_text(element, "pose", _pose(shape.R, shape.p)).set("rotation_format", "quat_xyzw")
        geometry = ElementTree.SubElement(element, "geometry")
        form = ElementTree.SubElement(geometry, shape.kind)
        if shape.kind == "mesh":
            _add_text(form, "uri", f"{MESHES}/{shape.mesh}")
            _add_text(form, "scale", numbers(shape.size))
        elif shape.kind in WHOLE:
            _add_text(form, WHOLE[shape.kind], numbers(shape.size))
        else:
            for name, value in zip(("radius", "length"), shape.size, strict=False):
                _add_text(form, name, number(value))
        if shape.colour is not None and not shape.is_collision:
            material = ElementTree.SubElement(element, "material")
            _add_text(material, "diffuse", numbers(shape.colour))


def _pose(rotation: Float[ndarray, "3 3"], origin: Float[ndarray, "3"]) -> str:
    w, x, y, z = quaternion(rotation)
    return numbers((*origin, x, y, z, w))


def _add_text(parent: ElementTree.Element, tag: str, text: str) -> ElementTree.Element:
    element = ElementTree.SubElement(parent, tag)
    element.text = text
    return element
