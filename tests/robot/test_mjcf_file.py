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


def test_a_missing_mesh_is_named_where_the_file_includes_another(tmp_path: Path) -> None:
    path = arm(tmp_path, '<mesh name="part" file="absent.stl"/>')
    path.write_text(path.read_text().replace("<asset>", '<include file="other.xml"/><asset>'))
    (tmp_path / "other.xml").write_text("<mujocoinclude/>")
    with pytest.raises(RobotError, match=r"absent\.stl"):
        load_robot(path)
