"""MJCF, written anew from the robot's tree: body frames are joint frames."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from oed.export.calibrated_robot import CalibratedRobot, link_inertial
from oed.export.own_name import own_name
from oed.export.shapes import MESHES, BodyShape, Shapes
from oed.export.xml_text import number, numbers, quaternion, write_xml

NO_SHAPES = Shapes()


def write_mjcf(
    calibrated: CalibratedRobot,
    path: str | Path,
    *,
    shapes: Shapes = NO_SHAPES,
    dry_friction: bool = True,
) -> Path:
    """Write a robot as MJCF.

    Args:
        calibrated: To write.
        path: Of the new file.
        shapes: Of its bodies.
        dry_friction: Whether joints have their Coulomb friction, as MuJoCo's `frictionloss`.

    Returns:
        The path.
    """
    robot = calibrated.robot
    root = ElementTree.Element("mujoco", model=own_name(robot))
    ElementTree.SubElement(
        root, "compiler", angle="radian", autolimits="true", meshdir=MESHES, inertiafromgeom="false"
    )
    ElementTree.SubElement(root, "option", gravity=numbers(robot.gravity))
    if any(shape.mesh for shape in shapes.shapes):
        _add_meshes(ElementTree.SubElement(root, "asset"), shapes)
    bodies = {-1: ElementTree.SubElement(root, "worldbody")}
    _add_shapes(bodies[-1], shapes, -1)
    actuators = ElementTree.SubElement(root, "actuator")
    for i in robot.outward:
        joint = robot.joints[i]
        bodies[i] = ElementTree.SubElement(
            bodies[joint.parent],
            "body",
            name=joint.link,
            pos=numbers(joint.p_PJ),
            quat=numbers(quaternion(joint.R_PJ)),
        )
        _add_inertial(bodies[i], calibrated, i)
        _add_joint(bodies[i], calibrated, i, dry_friction=dry_friction)
        _add_shapes(bodies[i], shapes, i)
        motor = {"name": joint.name, "joint": joint.name, "gear": "1"}
        effort = robot.limits.torque[i]
        if np.isfinite(effort).all():
            motor["ctrlrange"] = numbers(effort)
        ElementTree.SubElement(actuators, "motor", motor)
    _exclude_neighbours(root, calibrated, shapes)
    path = Path(path)
    write_xml(path, root)
    return path


def _add_inertial(body: ElementTree.Element, calibrated: CalibratedRobot, i: int) -> None:
    found = link_inertial(calibrated.robot, i, in_source_link=False)
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = found.inertia
    ElementTree.SubElement(
        body,
        "inertial",
        pos=numbers(found.com),
        mass=number(found.mass),
        fullinertia=numbers((xx, yy, zz, xy, xz, yz)),
    )


def _add_joint(
    body: ElementTree.Element, calibrated: CalibratedRobot, i: int, *, dry_friction: bool
) -> None:
    joint, limits = calibrated.robot.joints[i], calibrated.robot.limits
    element = ElementTree.SubElement(
        body,
        "joint",
        name=joint.name,
        type="hinge" if joint.kind == "revolute" else "slide",
        pos="0 0 0",
        axis=numbers(joint.axis),
        damping=number(calibrated.viscous[i]),
        frictionloss=number(calibrated.coulomb[i] if dry_friction else 0.0),
        armature=number(calibrated.rotor_inertia[i]),
    )
    if np.isfinite(limits.position[i]).all():
        element.set("range", numbers(limits.position[i]))


def _add_meshes(asset: ElementTree.Element, shapes: Shapes) -> None:
    """One asset a mesh and scale."""
    named = {_mesh_name(shape): shape for shape in shapes.shapes if shape.mesh}
    for name, shape in named.items():
        ElementTree.SubElement(
            asset, "mesh", name=name, file=shape.mesh, scale=numbers(shape.size), inertia="shell"
        )


def _mesh_name(shape: BodyShape) -> str:
    return f"{shape.mesh} {numbers(shape.size)}"


def _add_shapes(body: ElementTree.Element, shapes: Shapes, joint: int) -> None:
    for shape in shapes.of(joint):
        geom = {"name": shape.name, "type": shape.kind, "mass": "0"}
        geom |= {"pos": numbers(shape.p), "quat": numbers(quaternion(shape.R))}
        if shape.kind == "mesh":
            geom["mesh"] = _mesh_name(shape)
        else:
            # MuJoCo counts half edges and half lengths.
            halves = {"box": (0.5, 0.5, 0.5), "cylinder": (1, 0.5), "capsule": (1, 0.5)}
            shares = halves.get(shape.kind, (1,) * len(shape.size))
            geom["size"] = numbers(x * h for x, h in zip(shape.size, shares, strict=True))
        if shape.colour is not None:
            geom["rgba"] = numbers(shape.colour)
        # Group 3 is hidden by MuJoCo's viewers, as its own models have what only collides.
        geom |= {"group": "3"} if shape.is_collision else {"contype": "0", "conaffinity": "0"}
        ElementTree.SubElement(body, "geom", geom)


def _exclude_neighbours(
    root: ElementTree.Element, calibrated: CalibratedRobot, shapes: Shapes
) -> None:
    """Let the base and what hangs from it touch: MuJoCo lets neighbours, but for the world's."""
    if not any(shape.is_collision for shape in shapes.of(-1)):
        return
    contact = ElementTree.SubElement(root, "contact")
    for joint in calibrated.robot.joints:
        if joint.parent == -1:
            ElementTree.SubElement(contact, "exclude", body1="world", body2=joint.link)
