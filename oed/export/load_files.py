"""A load as other programs take it: a link of URDF, SDF and MJCF, a ROS 2 message, a line of URScript.

Every format has the same numbers in its own order: mass [kg], centre of mass in the holding frame [m],
and inertia about that centre in the frame's axes [kg m^2].
"""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.load.quantities import central_inertia
from oed.export.calibrated_robot import Inertial
from oed.export.xml_text import number, numbers, write_xml
from oed.report.json_file import write_atomically

LINK = "load"
ENTRIES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def write_load(parameters: Float[ndarray, "10"], frame: str, out: Path) -> tuple[str, ...]:
    """Write a load for every program that is known here.

    Args:
        parameters: Of a body that can exist, about the frame that holds it.
        frame: That frame's name.
        out: Folder to write to.

    Returns:
        Names of the files.
    """
    mass = float(parameters[0])
    body = Inertial(mass, parameters[1:4] / mass, central_inertia(parameters))
    write_xml(out / "load.urdf", _urdf(body))
    write_xml(out / "load.sdf", _sdf(body))
    write_xml(out / "load.xml", _mjcf(body))
    write_atomically(out / "load_message.yaml", _message(body, frame))
    write_atomically(out / "load.script", _script(body))
    return ("load.urdf", "load.sdf", "load.xml", "load_message.yaml", "load.script")


def _urdf(body: Inertial) -> ElementTree.Element:
    """A robot of one link, to be joined to the holding frame by a fixed joint of no offset."""
    root = ElementTree.Element("robot", name=LINK)
    link = ElementTree.SubElement(root, "link", name=LINK)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=numbers(body.com), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=number(body.mass))
    values = {k: number(x) for k, x in zip(ENTRIES, _upper(body), strict=True)}
    ElementTree.SubElement(inertial, "inertia", values)
    return root


def _sdf(body: Inertial) -> ElementTree.Element:
    root = ElementTree.Element("sdf", version="1.9")
    model = ElementTree.SubElement(root, "model", name=LINK)
    link = ElementTree.SubElement(model, "link", name=LINK)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "pose").text = numbers((*body.com, 0.0, 0.0, 0.0))
    ElementTree.SubElement(inertial, "mass").text = number(body.mass)
    inertia = ElementTree.SubElement(inertial, "inertia")
    for name, value in zip(ENTRIES, _upper(body), strict=True):
        ElementTree.SubElement(inertia, name).text = number(value)
    return root


def _mjcf(body: Inertial) -> ElementTree.Element:
    root = ElementTree.Element("mujoco", model=LINK)
    held = ElementTree.SubElement(ElementTree.SubElement(root, "worldbody"), "body", name=LINK)
    # MuJoCo takes no inertia of a body that nothing lets move.
    ElementTree.SubElement(held, "freejoint")
    xx, xy, xz, yy, yz, zz = _upper(body)
    ElementTree.SubElement(
        held,
        "inertial",
        pos=numbers(body.com),
        mass=number(body.mass),
        fullinertia=numbers((xx, yy, zz, xy, xz, yz)),
    )
    return root


def _message(body: Inertial, frame: str) -> str:
    x, y, z = (float(c) for c in body.com)
    inertia = "".join(f"  {k}: {v:.9g}\n" for k, v in zip(ENTRIES, _upper(body), strict=True))
    return (
        "# geometry_msgs/msg/InertiaStamped. For a UR driver, ur_msgs/srv/SetPayload takes m as mass\n"
        "# and com as center_of_gravity.\n"
        f"header:\n  frame_id: {json.dumps(frame)}\n"
        f"inertia:\n  m: {body.mass:.9g}\n  com: {{x: {x:.9g}, y: {y:.9g}, z: {z:.9g}}}\n" + inertia
    )


def _script(body: Inertial) -> str:
    """URScript: inertia as [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] about the centre, in the flange's axes."""
    xx, xy, xz, yy, yz, zz = (f"{x:.6g}" for x in _upper(body))
    centre = ", ".join(f"{c:.6g}" for c in body.com)
    return (
        f"set_target_payload({body.mass:.6g}, [{centre}], [{xx}, {yy}, {zz}, {xy}, {xz}, {yz}])\n"
    )


def _upper(body: Inertial) -> Float[ndarray, "6"]:
    return body.inertia[np.triu_indices(3)]
