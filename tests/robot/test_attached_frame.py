import dataclasses

import numpy as np
import pinocchio as pin
import pytest

from oed.errors import RobotError
from oed.robot import load_robot
from oed.robot.attached_frame import find_frame, frame_names
from oed.robot.inertia import parameters_from_pseudo_inertia, pseudo_inertia
from tests.paths import example_robot

UR5 = example_robot("ur_description/urdf/ur5_robot.urdf")
PANDA = example_robot("panda_description/urdf/panda.urdf")

LINK = '<link name="{0}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
JOINT = '<joint name="{1}_turns" type="continuous"><parent link="{0}"/><child link="{1}"/><axis xyz="0 0 1"/></joint>'
TWO_ARMS = (
    '<robot name="both"><link name="base"/>'
    + "".join(LINK.format(f"{side}_{k}") for side in ("right", "left") for k in (1, 2))
    + "".join(
        JOINT.format("base", f"{side}_1") + JOINT.format(f"{side}_1", f"{side}_2")
        for side in ("right", "left")
    )
    + "</robot>"
)


@pytest.fixture(scope="module")
def ur5():
    return load_robot(UR5)


@pytest.mark.parametrize("name", ["tool0", "ee_link", "wrist_3_link", "wrist_1_link"])
def test_a_frame_stands_where_pinocchio_has_it(ur5, name):
    model = pin.buildModelFromUrdf(str(UR5))
    frame = model.frames[model.getFrameId(name)]
    found = find_frame(ur5, name)
    assert ur5.joint_names[found.joint] == model.names[frame.parentJoint]
    # Pinocchio's joint frame and ours are one at a joint whose axis is one of its frame's.
    assert found.p_JF == pytest.approx(frame.placement.translation, abs=1e-9)
    assert pytest.approx(frame.placement.rotation, abs=1e-9) == found.R_JF


def test_the_flange_is_taken_where_nothing_is_named(ur5):
    assert find_frame(ur5).name == "tool0"
    assert find_frame(load_robot("builtin:imi_scara")).name == "link_2"


def test_parameters_are_taken_along_to_the_frame(ur5):
    found = find_frame(ur5, "tool0")
    body = parameters_from_pseudo_inertia(np.diag([0.01, 0.02, 0.03, 1.5]))
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = found.R_JF, found.p_JF
    about_joint = parameters_from_pseudo_inertia(pose @ pseudo_inertia(body) @ pose.T)
    assert found.from_body @ about_joint == pytest.approx(body, abs=1e-12)


def test_what_is_no_frame_of_the_arm_is_refused_in_one_line(ur5):
    with pytest.raises(RobotError, match=r"no frame 'flansch'; it moves .*wrist_3_link"):
        find_frame(ur5, "flansch")
    with pytest.raises(RobotError, match="stands still"):
        find_frame(ur5, "base_link")
    with pytest.raises(RobotError, match="no frame 'hand'; it moves link_1, link_2"):
        find_frame(load_robot("builtin:imi_scara"), "hand")


def test_a_hand_that_moves_is_no_end_of_the_arm():
    assert find_frame(load_robot(PANDA)).name == "panda_link7"


def test_an_arm_with_two_ends_asks_which_one(tmp_path):
    both = tmp_path / "both.urdf"
    both.write_text(TWO_ARMS, encoding="utf-8")
    with pytest.raises(RobotError, match=r"2 ends \(right_2, left_2\).*--frame"):
        find_frame(load_robot(both))
    assert find_frame(load_robot(both), "left_2").joint == 3


def test_links_that_move_are_listed(ur5):
    assert "tool0" in frame_names(ur5)
    assert "base_link" not in frame_names(ur5)
    without_file = dataclasses.replace(ur5, description=None)
    assert frame_names(without_file) == tuple(joint.link for joint in ur5.joints)
