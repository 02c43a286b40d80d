import dataclasses

import numpy as np
import pytest

from oed.estimation.load.same_arm import OtherArm, check_same_arm
from oed.experiment.dataset import DataSet
from oed.experiment.drive import Drive
from oed.robot import load_robot
from tests.estimation.load.carrying_arm import ROBOT


def data(robot=ROBOT, name="bare", **more):
    return DataSet(name, "here", "CC0", robot, more.pop("torque", "current"), **more)


def changed(joint, **fields):
    joints = list(ROBOT.joints)
    joints[joint] = dataclasses.replace(joints[joint], **fields)
    return dataclasses.replace(ROBOT, joints=tuple(joints))


PLACES = {-1: -1, 0: 1, 1: 0, 2: 2, 3: 3, 4: 4}  # of the first two joints, exchanged
MOVED = [dataclasses.replace(joint, parent=PLACES[joint.parent]) for joint in ROBOT.joints]
REORDERED = dataclasses.replace(ROBOT, joints=(MOVED[1], MOVED[0], *MOVED[2:]))


@pytest.mark.parametrize(
    ("loaded", "line"),
    [
        (data(load_robot("builtin:imi_scara")), "other joints, shoulder_pan_joint"),
        (data(REORDERED), "another order.*one order"),
        (data(changed(2, p_PJ=np.array([0.0, 0.0, 0.5]))), "elbow_joint.*same file"),
        (data(changed(5, kind="prismatic")), "wrist_3_joint.*revolute and prismatic"),
        (data(ROBOT.with_gravity(np.array([0.0, 9.81, 0.0]))), "gravity.*mounted"),
        (data(ROBOT.with_amperes()), "in N m and in A.*current_to_torque"),
        (data(torque="measured"), "current and measured.*one source"),
        (data(drive=Drive(current_to_torque=np.full(6, 9.0))), "current_to_torque is .*9"),
    ],
)
def test_what_is_not_one_arm_is_refused_in_one_line(loaded, line):
    bare = data(drive=Drive(current_to_torque=np.full(6, 10.0)))
    with pytest.raises(OtherArm, match=line) as refused:
        check_same_arm(bare, dataclasses.replace(loaded, name="loaded"))
    assert "\n" not in str(refused.value)
    assert "bare and loaded" in str(refused.value)


def test_one_arm_passes_and_fingers_that_moved_are_noted():
    open_hand = dataclasses.replace(ROBOT, locked=("finger",), locked_at=(0.04,))
    closed = dataclasses.replace(ROBOT, locked=("finger",), locked_at=(0.01,))
    assert check_same_arm(data(), data()) == ()
    (note,) = check_same_arm(data(open_hand), data(closed))
    assert "'finger' is held at 0.04 without and 0.01 with" in note
