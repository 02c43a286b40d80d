"""Frames of a robot's file that an arm carries, such as its flange."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.multibody.plant import MultibodyPlant

from oed.errors import RobotError
from oed.robot.arm_chain import find_arm
from oed.robot.inertia import transform_parameters
from oed.robot.merged_tree import MergedTree
from oed.robot.robot import Joint, Robot
from oed.robot.robot_file import load_plant, outward_names

# What ROS-Industrial calls the place where a tool is mounted, the one to be preferred first
# (REP 199, "Coordinate frames for serial industrial manipulators").
FLANGES = ("tool0", "flange")


@dataclass(frozen=True)
class AttachedFrame:
    """A frame F that moves with the body of a joint.

    Attributes:
        name: In the robot's file.
        joint: Index of the joint that carries it.
        R_JF: Axes of F in the body frame J.
        p_JF: Origin of F in J [m].
    """

    name: str
    joint: int
    R_JF: Float[ndarray, "3 3"]
    p_JF: Float[ndarray, "3"]

    @property
    def from_body(self) -> Float[ndarray, "10 10"]:
        """Parameters of a body about J to those about F, which is a linear map."""
        turned, origin = self.R_JF.T, -self.R_JF.T @ self.p_JF
        return np.column_stack([transform_parameters(e, turned, origin) for e in np.eye(10)])


def find_frame(robot: Robot, name: str = "") -> AttachedFrame:
    """A frame that the arm carries.

    Args:
        robot: The arm.
        name: Of a link or frame of its file; where the arm ends if empty: the frame that is
            called a flange, else the link of the last joint.

    Raises:
        RobotError: If there is no such frame, it stands still, or the arm has several ends.
    """
    if robot.description is None:
        return _of_joint(robot, _named_joint(robot, name) if name else _last_joint(robot))
    plant = load_plant(robot.description)
    tree = MergedTree(plant, robot.joint_names, robot.held)
    if name:
        return _of_file(robot, plant, tree, name)
    last = _last_joint(robot, plant)
    for flange in FLANGES:
        if plant.HasFrameNamed(flange):
            found = _of_file(robot, plant, tree, flange)
            if found.joint == last:
                return found
    return _of_joint(robot, last)


def frame_names(robot: Robot) -> tuple[str, ...]:
    """Links of the robot's file that its joints move."""
    if robot.description is None:
        return tuple(joint.link for joint in robot.joints)
    plant = load_plant(robot.description)
    return tuple(sorted(MergedTree(plant, robot.joint_names, robot.held).carried))


def _last_joint(robot: Robot, plant: MultibodyPlant | None = None) -> int:
    """The last of the arm's joints, before a hand branches off."""
    names, parents = robot.joint_names, [joint.parent for joint in robot.joints]
    if plant is not None:
        names = outward_names(plant)
        parents = [joint.parent for joint in MergedTree(plant, names, {}).joints]
    arm = [name for name in find_arm(names, parents).names if name in robot.joint_names]
    last = robot.joint_names.index(arm[-1])
    ends = [i for i in range(robot.n) if i not in {joint.parent for joint in robot.joints}]
    others = [i for i in ends if last not in _way(robot, i)]
    if others:
        named = ", ".join(robot.joints[i].link for i in (last, *others))
        raise RobotError(
            f"{robot.source or robot.name}: the arm has {1 + len(others)} ends ({named}); name the "
            "one that holds the load by --frame"
        )
    return last


def _way(robot: Robot, joint: int) -> list[int]:
    """Joints from the base to one."""
    way = [joint]
    while robot.joints[way[-1]].parent >= 0:
        way.append(robot.joints[way[-1]].parent)
    return way


def _named_joint(robot: Robot, name: str) -> int:
    for i, joint in enumerate(robot.joints):
        if joint.link == name:
            return i
    raise _unknown(robot, name)


def _of_joint(robot: Robot, joint: int) -> AttachedFrame:
    """The frame of the link of a joint, as the file has it."""
    carried: Joint = robot.joints[joint]
    R_JL = carried.R_LJ.T
    return AttachedFrame(carried.link, joint, R_JL, -R_JL @ carried.p_LJ)


def _of_file(robot: Robot, plant: MultibodyPlant, tree: MergedTree, name: str) -> AttachedFrame:
    if not plant.HasFrameNamed(name):
        raise _unknown(robot, name)
    frame = plant.GetFrameByName(name)
    joint, X_JB = tree.pose(frame.body())
    if joint < 0:
        raise RobotError(f"frame {name!r} of {robot.source} stands still: it carries no load")
    X_JF = X_JB @ frame.GetFixedPoseInBodyFrame()
    return AttachedFrame(
        name, joint, np.asarray(X_JF.rotation().matrix()), np.asarray(X_JF.translation())
    )


def _unknown(robot: Robot, name: str) -> RobotError:
    moving = ", ".join(frame_names(robot))
    return RobotError(f"{robot.source or robot.name} has no frame {name!r}; it moves {moving}")
