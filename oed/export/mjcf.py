"""MJCF, written anew from the robot's tree: body frames are joint frames."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from oed.export.calibrated_robot import CalibratedRobot, link_inertial
from oed.export.xml_text import number, numbers, quaternion, write_xml


def write_mjcf(calibrated: CalibratedRobot, path: str | Path) -> Path:
    """Write a robot as MJCF, without geometry.

    Args:
        calibrated: To write.
        path: Of the new file.

    Returns:
        The path.
    """
    robot = calibrated.robot
    root = ElementTree.Element("mujoco", model=robot.name)
    ElementTree.SubElement(root, "compiler", angle="radian", autolimits="true")
    ElementTree.SubElement(root, "option", gravity=numbers(robot.gravity))
    bodies = {-1: ElementTree.SubElement(root, "worldbody")}
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
        _add_joint(bodies[i], calibrated, i)
        ElementTree.SubElement(actuators, "motor", name=joint.name, joint=joint.name, gear="1")
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


def _add_joint(body: ElementTree.Element, calibrated: CalibratedRobot, i: int) -> None:
    joint, limits = calibrated.robot.joints[i], calibrated.robot.limits
    element = ElementTree.SubElement(
        body,
        "joint",
        name=joint.name,
        type="hinge" if joint.kind == "revolute" else "slide",
        pos="0 0 0",
        axis=numbers(joint.axis),
        damping=number(calibrated.viscous[i]),
        frictionloss=number(calibrated.coulomb[i]),
        armature=number(calibrated.rotor_inertia[i]),
    )
    if np.isfinite(limits.position[i]).all():
        element.set("range", numbers(limits.position[i]))
