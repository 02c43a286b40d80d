"""MJCF files are read whatever has become of their meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oed.errors import RobotError
from oed.robot import load_robot

ARM = """
<mujoco model="arm">
  <default><default class="visual"><geom type="mesh" group="2"/></default></default>
  <asset>{assets}</asset>
  <worldbody>
    <body name="base">{geom}
      <body name="upper" pos="0 0 0.3">
        <joint name="lift" type="hinge" axis="0 1 0" range="-90 90"/>
        <inertial pos="0.1 0.02 0" mass="2" diaginertia="0.02 0.03 0.04"/>{geom}
        <geom name="hull" type="capsule" size="0.05" fromto="0 0 0 0.4 0 0"/>
        <body name="fore" pos="0.4 0 0">
          <joint name="slide" type="slide" axis="1 0 0" range="-0.1 0.3"/>
          <inertial pos="0.05 0 0.03" mass="1.5" diaginertia="0.01 0.02 0.015"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator><motor name="m" joint="lift" ctrlrange="-9 9"/></actuator>
</mujoco>
"""
GEOM = '<geom class="visual" mesh="part"/>'


def arm(folder: Path, assets: str, geom: str = GEOM, name: str = "arm.xml") -> Path:
    """The arm with the assets, and a geom at its base and its upper link."""
    path = folder / name
    path.write_text(ARM.format(assets=assets, geom=geom))
    return path


@pytest.mark.parametrize("name", ["arm.xml", "arm.mjcf"])
@pytest.mark.parametrize("file", ["absent.obj", "part.stl", "absent.stl"])
def test_meshes_that_drake_cannot_read_change_nothing(tmp_path: Path, file: str, name: str) -> None:
    (tmp_path / "part.stl").write_bytes(bytes(84))
    robot = load_robot(arm(tmp_path, f'<mesh name="part" file="{file}"/>', name=name))
    plain = load_robot(arm(tmp_path, "", geom="", name="plain.xml"))
    assert robot.joint_names == ("lift", "slide")
    assert np.array_equal(robot.parameters, plain.parameters)
    assert np.array_equal(robot.limits.position, plain.limits.position)
    assert np.array_equal(robot.limits.torque, plain.limits.torque)


def test_a_file_without_meshes_may_have_either_suffix(tmp_path: Path) -> None:
    robots = [load_robot(arm(tmp_path, "", "", name)) for name in ("arm.xml", "arm.mjcf")]
    assert np.array_equal(robots[0].parameters, robots[1].parameters)


def test_what_else_is_wrong_is_still_said(tmp_path: Path) -> None:
    path = arm(tmp_path, '<mesh name="part" file="absent.stl"/>')
    path.write_text(path.read_text().replace('type="slide"', 'type="screw"'))
    with pytest.raises(RobotError, match="screw"):
        load_robot(path)


def test_what_is_included_is_taken_in(tmp_path: Path) -> None:
    path = arm(tmp_path, "", geom="")
    whole = load_robot(path)
    text = path.read_text()
    start, end = text.index("<worldbody>"), text.index("</worldbody>") + len("</worldbody>")
    (tmp_path / "body.xml").write_text(f"<mujocoinclude>{text[start:end]}</mujocoinclude>")
    path.write_text(text[:start] + '<include file="body.xml"/>' + text[end:])
    assert np.array_equal(load_robot(path).parameters, whole.parameters)


def test_files_that_include_one_another_are_refused(tmp_path: Path) -> None:
    path = arm(tmp_path, "", geom="")
    path.write_text(path.read_text().replace("<worldbody>", '<include file="arm.xml"/><worldbody>'))
    with pytest.raises(RobotError, match=r"arm\.xml: files include one another by 'arm\.xml'"):
        load_robot(path)


def test_a_body_whose_inertia_is_that_of_a_missing_mesh_is_told_of(tmp_path: Path) -> None:
    path = arm(tmp_path, '<mesh name="part" file="absent.stl"/>')
    (note,) = load_robot(path).notes
    assert note == "meshes cannot be read, so that bodies have no inertia: base"


TIE = '<equality><connect body1="fore" body2="base" anchor="0 0 0"/></equality>'


def test_bodies_tied_to_each_other_are_a_closed_loop(tmp_path: Path) -> None:
    path = arm(tmp_path, "", geom="")
    path.write_text(path.read_text().replace("<actuator>", TIE + "<actuator>"))
    with pytest.raises(RobotError, match=r"arm\.xml: bodies 'fore' and 'base' are tied"):
        load_robot(path)


def test_a_tie_of_what_does_not_move_against_each_other_is_none(tmp_path: Path) -> None:
    path = arm(tmp_path, "", geom="")
    text = path.read_text().replace("<actuator>", TIE.replace('"base"', '"upper"') + "<actuator>")
    path.write_text(text)
    assert load_robot(path, joints=["lift"]).joint_names == ("lift",)


def test_an_impossible_inertia_is_replaced_here_too(tmp_path: Path) -> None:
    path = arm(tmp_path, "", geom="")
    path.write_text(path.read_text().replace("0.02 0.03 0.04", "0.02 0.03 0.4"))
    robot = load_robot(path)
    assert "'upper': no body has principal moments of inertia 0.02, 0.03, 0.4" in robot.notes[0]
    radius = np.cbrt(3 * 2 / (4 * np.pi * 1000))
    assert robot.parameters[4] == pytest.approx(0.4 * 2 * radius**2 + 2 * 0.02**2)  # Ixx, Steiner
