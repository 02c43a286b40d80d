"""Robots from files: what is merged, locked, ordered and refused."""

from pathlib import Path

import numpy as np
import pytest

from oed.dynamics.cross_check import cross_check
from oed.errors import RobotError
from oed.robot import arm_joints, load_robot
from tests.paths import example_robot
from tests.studies.sound_inputs import URDF

MJCF = """
<mujoco model="arm">
  <worldbody>
    <body name="upper" pos="0 0 0.3">
      <joint name="lift" type="hinge" axis="0 1 0" pos="0.02 0 0.01" range="-90 90"/>
      <inertial pos="0.1 0.02 0" mass="2" diaginertia="0.02 0.03 0.04"/>
      <body name="fore" pos="0.4 0 0" euler="0 30 0">
        <joint name="slide" type="slide" axis="1 0 0" range="-0.1 0.3"/>
        <inertial pos="0.05 0 0.03" mass="1.5" diaginertia="0.01 0.02 0.015"/>
        <body name="tool" pos="0.1 0 0">
          <inertial pos="0 0 0.05" mass="0.5" diaginertia="0.001 0.001 0.001"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""

SDF = """<?xml version="1.0"?>
<sdf version="1.7">
  <model name="arm">
    <link name="base"/>
    <link name="upper">
      <pose relative_to="turn">0.1 0 0.2 0.3 0 0</pose>
      <inertial><pose>0.1 0 0 0 0 0</pose><mass>2</mass>
        <inertia><ixx>0.02</ixx><iyy>0.03</iyy><izz>0.04</izz>
                 <ixy>0.001</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>
    </link>
    <joint name="turn" type="revolute">
      <pose relative_to="base">0 0 0.1 0 0.4 0</pose>
      <parent>base</parent><child>upper</child>
      <axis><xyz>0 0.6 0.8</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis>
    </joint>
  </model>
</sdf>
"""

URDF_WITH_MESH = """<?xml version="1.0"?>
<robot name="one">
  <link name="base"/>
  <link name="arm">
    <visual><geometry><mesh filename="package://nowhere/arm.dae"/></geometry></visual>
    <inertial><origin xyz="0.1 0 0"/><mass value="1"/>
      <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="1" velocity="3" effort="7"/>
  </joint>
</robot>
"""


def _written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text)
    return path


@pytest.mark.parametrize(("name", "text"), [("arm.xml", MJCF), ("arm.sdf", SDF)])
def test_other_formats_give_drakes_torques(tmp_path: Path, name: str, text: str) -> None:
    robot = load_robot(_written(tmp_path, name, text))
    assert cross_check(robot).agrees


def test_prismatic_joints_and_merged_tools_are_read_from_mjcf(tmp_path: Path) -> None:
    robot = load_robot(_written(tmp_path, "arm.xml", MJCF))
    assert [joint.kind for joint in robot.joints] == ["revolute", "prismatic"]
    assert robot.parameters[0::10] == pytest.approx([2.0, 2.0])  # fore 1.5 kg + tool 0.5 kg


def test_missing_meshes_stop_nobody(tmp_path: Path) -> None:
    robot = load_robot(_written(tmp_path, "one.urdf", URDF_WITH_MESH))
    limits = robot.limits
    assert limits.position.tolist() == [[-2.0, 1.0]]
    assert limits.velocity.tolist() == [[-3.0, 3.0]]
    assert limits.torque.tolist() == [[-7.0, 7.0]]
    assert np.isinf(limits.acceleration).all()


def test_joints_are_ordered_from_the_base_outward() -> None:
    robot = load_robot(example_robot("so_arm_description/urdf/so101.urdf"))
    assert [joint.parent for joint in robot.joints] == [-1, 0, 1, 2, 3, 4]


def test_columns_follow_the_named_order() -> None:
    path = example_robot("ur_description/urdf/ur5_robot.urdf")
    names = load_robot(path).joint_names
    assert load_robot(path, joints=names[::-1]).joint_names == names[::-1]
    assert cross_check(load_robot(path, joints=names[::-1])).agrees


def test_locked_joints_carry_their_load() -> None:
    path = example_robot("panda_description/urdf/panda.urdf")
    whole = load_robot(path)
    some = load_robot(path, joints=["panda_joint2", "panda_joint4"])
    assert some.n == 2
    assert set(some.locked) == {*whole.joint_names, *whole.locked} - set(some.joint_names)
    assert cross_check(some).agrees
    beyond_joint_4 = whole.parameters[0::10][3:].sum()
    assert some.parameters[10] == pytest.approx(beyond_joint_4)


def test_a_locked_position_moves_what_it_carries() -> None:
    path = example_robot("ur_description/urdf/ur5_robot.urdf")
    first = load_robot(path).joint_names[:1]
    elbow = load_robot(path).joint_names[2]
    straight = load_robot(path, joints=first)
    bent = load_robot(path, joints=first, locked={elbow: np.pi / 2})
    assert straight.parameters[0] == pytest.approx(bent.parameters[0])  # mass
    assert abs(straight.parameters[9] - bent.parameters[9]) > 0.1  # inertia about the axis


@pytest.mark.parametrize(
    ("robot", "last"),
    [
        ("panda_description/urdf/panda.urdf", "panda_joint7"),
        ("kinova_description/robots/kinova.urdf", "j2s6s200_joint_6"),
        ("tiago_description/robots/tiago.urdf", "arm_7_joint"),
        ("ur_description/urdf/ur5_robot.urdf", "wrist_3_joint"),
    ],
)
def test_the_arm_ends_where_the_hand_begins(robot: str, last: str) -> None:
    assert arm_joints(example_robot(robot))[-1] == last


def test_unknown_joint_is_named_with_those_that_exist() -> None:
    with pytest.raises(RobotError, match=r"no joint 'elbow'.*panda_joint4"):
        load_robot(example_robot("panda_description/urdf/panda.urdf"), joints=["elbow"])


def test_an_active_joint_cannot_be_locked() -> None:
    path = example_robot("panda_description/urdf/panda.urdf")
    with pytest.raises(RobotError, match="cannot lock"):
        load_robot(path, joints=["panda_joint1"], locked={"panda_joint1": 0.3})


def test_bad_files_are_refused_in_one_line(tmp_path: Path) -> None:
    for name, text, why in (
        ("no.urdf", "this is no xml", "cannot read"),
        ("robot.txt", "", "unknown kind"),
        ("far.urdf", URDF.replace('"0.4 0 0"', '"1e150 0 0"'), "'joint_2' lies 1e\\+150 m off"),
        ("heavy.urdf", URDF.replace('mass value="3"', 'mass value="1e20"'), "link 'link_1' has a"),
        ("still.urdf", '<robot name="s"><link name="a"/></robot>', "no revolute"),
    ):
        with pytest.raises(RobotError, match=why):
            load_robot(_written(tmp_path, name, text))
    with pytest.raises(RobotError, match="no such robot file"):
        load_robot(tmp_path / "absent.urdf")
    with pytest.raises(RobotError, match="no built-in robot 'puma'"):
        load_robot("builtin:puma")
