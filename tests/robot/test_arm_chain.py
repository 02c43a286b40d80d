"""Which chain of joints is the arm, and what is said of the others."""

from __future__ import annotations

import pytest

from oed.robot import load_arm
from oed.robot.arm_chain import find_arm
from tests.paths import example_robot


def tree(*chains: str) -> tuple[list[str], list[int]]:
    """Joints of one letter each, and their parents: "ab" hangs b from a; a known one continues."""
    names: list[str] = []
    parents: list[int] = []
    for chain in chains:
        before = -1
        for joint in chain:
            if joint not in names:
                names.append(joint)
                parents.append(before)
            before = names.index(joint)
    return names, parents


@pytest.mark.parametrize(
    ("chains", "arm", "others"),
    [
        (("abcdef",), "abcdef", []),
        (("abcdefX", "abcdefY"), "abcdef", []),  # a gripper of two fingers
        (("abcdefghij", "abcdefklmn", "abcdefopq"), "abcdef", []),  # a hand
        (("abcdefghij", "abcdefklm"), "abcdef", []),  # its thumb is longer than its finger
        (("abcdefgh", "abcx"), "abcdefgh", []),  # a camera on the way
        (("tabcde", "tuvwxy"), "tabcde", ["tuvwxy"]),  # two arms on a torso
        (("abcde", "uvwxyz"), "uvwxyz", ["abcde"]),  # the longest, wherever it stands
        (("l", "r", "abcdef"), "abcdef", []),  # wheels
        (("ab", "cd"), "ab", ["cd"]),  # all that there is
        (("tabcdefX", "tabcdefY", "tuvwxyzS", "tuvwxyzT", "th"), "tabcdef", ["tuvwxyz"]),
    ],
)
def test_the_arm_is_the_longest_chain_up_to_its_hand(
    chains: tuple[str, ...], arm: str, others: list[str]
) -> None:
    found = find_arm(*tree(*chains))
    assert "".join(found.names) == arm
    assert ["".join(chain) for chain in found.others] == others
    assert bool(found.notes) == bool(others)


@pytest.mark.parametrize(
    ("robot", "count", "first", "last", "another"),
    [
        ("romeo_description/urdf/romeo.urdf", 8, "TrunkYaw", "LWristPitch", "RWristPitch"),
        ("pr2_description/urdf/pr2.urdf", 8, "torso_lift_joint", "r_wrist_roll_joint", "l_wrist"),
        ("tiago_description/robots/tiago_dual.urdf", 8, "torso_lift_joint", "arm_left_7_joint",
         "torso_lift_joint arm_right_1_joint"),
    ],
)  # fmt: skip
def test_of_several_arms_one_is_taken_and_the_others_are_told(
    robot: str, count: int, first: str, last: str, another: str
) -> None:
    loaded = load_arm(example_robot(robot))
    assert loaded.n == count
    assert (loaded.joint_names[0], loaded.joint_names[-1]) == (first, last)
    assert "was taken; name the joints to take another: " in loaded.notes[0]
    assert another in loaded.notes[0]


def test_joints_that_are_named_are_taken_without_a_word() -> None:
    path = example_robot("tiago_description/robots/tiago_dual.urdf")
    names = tuple(f"arm_right_{i}_joint" for i in range(1, 8))
    robot = load_arm(path, joints=names)
    assert robot.joint_names == names
    assert not any("chains" in note for note in robot.notes)
