"""Joints that can hardly move are held still, and that is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oed.design.still_joints import hold_still_joints
from oed.errors import RobotError
from oed.robot import Robot, load_robot

INERTIAL = """<inertial><origin xyz="0.3 0 0"/><mass value="2"/>
<inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>"""


def arm(folder: Path, *ranges: tuple[float, float], kind: str = "revolute") -> Robot:
    """Links of 0.5 m one after the other, joints about z; the ranges are those of the joints."""
    parts = ['<robot name="arm"><link name="link_0"/>']
    for k, (lower, upper) in enumerate(ranges, start=1):
        parts.append(
            f'<link name="link_{k}">{INERTIAL}</link><joint name="joint_{k}" type="{kind}">'
            f'<parent link="link_{k - 1}"/><child link="link_{k}"/><origin xyz="0.5 0 0"/>'
            f'<axis xyz="0 0 1"/><limit lower="{lower}" upper="{upper}" velocity="3" effort="90"/>'
            "</joint>"
        )
    file = folder / "arm.urdf"
    file.write_text("".join([*parts, "</robot>"]))
    return load_robot(file)


@pytest.mark.parametrize(
    ("lower", "upper", "middle"),
    [(0.4, 0.401, 0.4005), (-1e-3, 1e-3, 0.0), (0.7, 0.7, 0.7)],
    ids=["milliradian", "about zero", "equal"],
)
def test_a_joint_that_can_hardly_move_is_held_at_the_middle_of_its_range(
    lower: float, upper: float, middle: float, tmp_path: Path
) -> None:
    held, notes = hold_still_joints(arm(tmp_path, (-2.0, 2.0), (lower, upper), (-1.0, 1.0)))
    assert held.joint_names == ("joint_1", "joint_3")
    assert held.held["joint_2"] == pytest.approx(middle, abs=1e-12)
    assert len(notes) == 1
    assert notes[0].startswith(f"joint_2 is held at {middle:.4g}: its range of")
    # The third joint sits where the second, turned by that much, puts it.
    where = np.array([0.5 + 0.5 * np.cos(middle), 0.5 * np.sin(middle), 0.0])
    np.testing.assert_allclose(held.joints[1].p_PJ, where, atol=1e-12)


def test_joints_that_move_are_left_alone(tmp_path: Path) -> None:
    robot = arm(tmp_path, (-2.0, 2.0), (0.4, 0.42))
    held, notes = hold_still_joints(robot)
    assert held is robot
    assert notes == ()


def test_limits_that_a_data_set_states_stay(tmp_path: Path) -> None:
    robot = arm(tmp_path, (-2.0, 2.0), (0.4, 0.401), (-1.0, 1.0))
    position = robot.limits.position.copy()
    position[0] = (-0.5, 0.25)
    stated = robot.with_limits(robot.limits.with_(position=position))
    held, _ = hold_still_joints(stated)
    assert held.limits.position.tolist() == [[-0.5, 0.25], [-1.0, 1.0]]


def test_a_slide_counts_by_a_pinion(tmp_path: Path) -> None:
    # 0.01 rad of a pinion of 5 cm is half a millimetre.
    robot = arm(tmp_path, (-0.2, 0.2), (0.0, 4e-4), (0.0, 6e-4), kind="prismatic")
    held, notes = hold_still_joints(robot)
    assert held.joint_names == ("joint_1", "joint_3")
    assert "0.0004 m" in notes[0]


@pytest.mark.parametrize(
    ("ranges", "told"),
    [
        (((0.0, 1e-12), (-3.1, 3.1)), "joint_1, 0 ... 1e-12, are closer"),
        (((0.0, 1e-3), (0.1, 0.101)), "no joint has a position range that matters"),
    ],
)
def test_what_leaves_no_motion_is_refused(ranges, told: str, tmp_path: Path) -> None:
    with pytest.raises(RobotError) as refusal:
        hold_still_joints(arm(tmp_path, *ranges))
    assert told in str(refusal.value)
