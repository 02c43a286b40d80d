"""URDF files that contradict themselves, mimic, or state an inertia that no body has."""

import re
from pathlib import Path

import numpy as np
import pytest

from oed.dynamics.cross_check import cross_check
from oed.errors import RobotError
from oed.robot import arm_joints, load_arm, load_robot
from tests.experiment.tiny_dataset import urdf_text
from tests.paths import example_robot

LIMIT = '<limit lower="-3" upper="3" velocity="4" effort="10"/>'
MASS = '<mass value="1"/>'
INERTIA = 'ixx="1" iyy="1" izz="1"'
MIMIC = '<mimic joint="joint_1" multiplier="-1"/>'
PANDA = "panda_description/urdf/panda.urdf"


def chain(folder: Path, old: str, new: str, joints: int = 3) -> Path:
    """A planar chain with `old` replaced where it occurs first."""
    text = urdf_text(joints)
    assert old in text
    path = folder / "arm.urdf"
    path.write_text(text.replace(old, new, 1))
    return path


def mimicking(folder: Path, follower: str) -> Path:
    """The chain in which one joint mimics the first."""
    head = f'<joint name="{follower}" type="revolute">'
    return chain(folder, head, head + MIMIC)


@pytest.mark.parametrize(
    ("limit", "why"),
    [
        ('<limit lower="3" upper="-3" velocity="4" effort="10"/>', "lower limit 3 is above upper"),
        ('<limit lower="1" velocity="4" effort="10"/>', "lower limit 1 is above upper limit 0"),
        ('<limit lower="-3" upper="3" velocity="-4" effort="10"/>', "velocity limit -4 is neg"),
        ('<limit lower="-3" upper="3" velocity="4" effort="-10"/>', "effort limit -10 is negative"),
    ],
)
def test_limits_that_contradict_themselves_are_named(tmp_path: Path, limit: str, why: str) -> None:
    with pytest.raises(RobotError, match=rf"arm\.urdf: joint 'joint_1': {why}"):
        load_robot(chain(tmp_path, LIMIT, limit))


def test_reversed_limits_in_another_format_are_one_line(tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    path.write_text(
        '<mujoco model="arm"><worldbody><body name="a"><joint name="j" range="90 -90"/>'
        '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>'
    )
    with pytest.raises(RobotError, match="lower limit above its upper one") as caught:
        load_robot(path)
    assert "\n" not in str(caught.value)


def test_a_joint_without_a_limit_element_is_not_limited(tmp_path: Path) -> None:
    limits = load_robot(chain(tmp_path, LIMIT, "")).limits
    assert limits.torque.tolist()[0] == [-float("inf"), float("inf")]
    assert limits.torque.tolist()[1] == [-10.0, 10.0]


def test_a_joint_that_mimics_another_is_held_like_one_that_was_not_named(tmp_path: Path) -> None:
    robot = load_robot(mimicking(tmp_path, "joint_3"))
    assert robot.joint_names == ("joint_1", "joint_2")
    assert robot.locked == ("joint_3",)


def test_a_follower_of_an_active_joint_is_held_and_told_of(tmp_path: Path) -> None:
    robot = load_robot(mimicking(tmp_path, "joint_3"), joints=["joint_1", "joint_2"])
    assert robot.held == {"joint_3": 0.0}
    (note,) = robot.notes
    assert "joint 'joint_3' mimics 'joint_1': it is held at 0, and what it carries" in note


@pytest.mark.parametrize("follower", ["joint_2", "joint_3"])
def test_a_follower_within_the_arm_is_none_of_its_joints(tmp_path: Path, follower: str) -> None:
    path = mimicking(tmp_path, follower)
    others = tuple(name for name in ("joint_1", "joint_2", "joint_3") if name != follower)
    assert arm_joints(path) == load_arm(path).joint_names == others


def test_a_follower_that_is_named_is_a_joint_of_its_own(tmp_path: Path) -> None:
    names = ("joint_1", "joint_2", "joint_3")
    robot = load_robot(mimicking(tmp_path, "joint_3"), joints=names)
    assert robot.joint_names == names
    assert "taken as a joint of its own" in robot.notes[0]


def test_a_follower_stands_where_its_leader_puts_it(tmp_path: Path) -> None:
    path = mimicking(tmp_path, "joint_3")
    path.write_text(path.read_text().replace('multiplier="-1"', 'multiplier="-2" offset="0.1"'))
    robot = load_robot(path, joints=["joint_2"], locked={"joint_1": 0.3})
    assert robot.held == {"joint_1": 0.3, "joint_3": pytest.approx(0.1 - 2 * 0.3)}
    assert robot.notes == ()


@pytest.mark.parametrize("leader", ["joint_3", "joint_2"])
def test_joints_that_mimic_in_a_circle_are_refused(tmp_path: Path, leader: str) -> None:
    path = mimicking(tmp_path, "joint_3")
    text = path.read_text().replace('mimic joint="joint_1"', f'mimic joint="{leader}"')
    head = '<joint name="joint_2" type="revolute">'
    path.write_text(text.replace(head, f'{head}<mimic joint="joint_3"/>'))
    with pytest.raises(RobotError, match=r"arm\.urdf: joint 'joint_\d' mimics itself"):
        load_robot(path)


def test_who_mimics_nobody_is_a_joint_of_its_own(tmp_path: Path) -> None:
    path = mimicking(tmp_path, "joint_3")
    path.write_text(path.read_text().replace('mimic joint="joint_1"', 'mimic joint="absent"'))
    robot = load_robot(path)
    assert robot.joint_names == ("joint_1", "joint_2", "joint_3")
    assert "mimics 'absent', which the file does not have" in robot.notes[0]


def test_the_arm_of_a_robot_whose_fingers_mimic_is_as_before() -> None:
    path = example_robot(PANDA)
    names = arm_joints(path)
    assert names == tuple(f"panda_joint{i}" for i in range(1, 8))
    assert set(load_robot(path, joints=names).locked) == {
        "panda_finger_joint1",
        "panda_finger_joint2",
    }


@pytest.mark.parametrize(
    ("old", "new", "why", "has_mass"),
    [
        (MASS, '<mass value="-1"/>', "a mass of -1 kg", False),
        (MASS, '<mass value="0"/>', "a mass of 0 kg but an inertia", False),
        (INERTIA, 'ixx="1" iyy="1" izz="9"', "moments of inertia 1, 1, 9", True),
        (INERTIA, 'ixx="-1" iyy="1" izz="1"', "moments of inertia -1, 1, 1", True),
    ],
)
def test_an_inertia_of_no_body_is_told_of_and_loads(
    tmp_path: Path, old: str, new: str, why: str, has_mass: bool
) -> None:
    robot = load_robot(chain(tmp_path, old, new))
    (fault,) = robot.inertia_faults
    assert fault.link == "link_1"
    assert why in fault.text
    assert fault.has_mass == has_mass
    assert robot.notes == (fault.replacement,)
    assert cross_check(robot, states=20).agrees  # Drake and Pinocchio, on the file as replaced
    # A ball of water: 0.4 m r^2, its volume 4/3 pi r^3 being m / 1000 kg/m^3; at the origin.
    ball = 0.4 * (3 / (4 * np.pi * 1000)) ** (2 / 3)
    expected = [1.0, 0, 0, 0, ball, 0, 0, ball, 0, ball] if has_mass else [0.0] * 10
    assert robot.parameters[:10] == pytest.approx(expected)


def test_what_does_not_move_or_has_no_inertia_at_all_is_no_fault(tmp_path: Path) -> None:
    text = urdf_text(2).replace('<link name="base"/>', '<link name="base"><inertial>'
        '<mass value="-1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        "</inertial></link>")  # fmt: skip
    (tmp_path / "base.urdf").write_text(text)
    assert load_robot(tmp_path / "base.urdf").inertia_faults == ()
    (tmp_path / "bare.urdf").write_text(
        re.sub("<inertial>.*?</inertial>", "", urdf_text(2), flags=re.DOTALL)
    )
    assert load_robot(tmp_path / "bare.urdf").inertia_faults == ()
    assert load_robot(example_robot(PANDA)).inertia_faults == ()
