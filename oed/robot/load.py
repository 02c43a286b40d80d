"""Robots from URDF, SDF and MJCF: kinematics, inertia and limits, nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint as DrakeJoint

from oed.errors import RobotError
from oed.robot.builtin import BUILTIN_ROBOTS
from oed.robot.limits import JointLimits
from oed.robot.merged_tree import MergedTree
from oed.robot.robot import Robot
from oed.robot.robot_file import is_movable, joints_of, load_plant, outward_names
from oed.robot.urdf_file import UrdfFacts, read_urdf

EARTH_GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2]


def load_robot(
    source: str | Path,
    *,
    joints: Sequence[str] | None = None,
    locked: Mapping[str, float] | None = None,
    gravity: Sequence[float] = EARTH_GRAVITY,
) -> Robot:
    """Load a fixed-base arm.

    Args:
        source: Path of a URDF, SDF or MJCF file, or "builtin:NAME".
        joints: Names of the active joints in the order of the columns; if None all revolute
            and prismatic joints that do not mimic another, from the base outward. The others
            are held still.
        locked: Position [rad or m] at which a joint is held; 0 if not given.
        gravity: In the base frame [m/s^2].

    Raises:
        RobotError: If the file cannot be read, contradicts itself, or lacks a joint that was
            named, or if such a joint mimics another or is mimicked.
    """
    if str(source).startswith("builtin:"):
        return _builtin(str(source), joints, np.asarray(gravity, dtype=float))
    facts = read_urdf(Path(source))  # first: what it refuses would make Drake give up
    plant = load_plant(source)
    movable = {joint.name(): joint for joint in joints_of(plant) if is_movable(joint)}
    names = (
        tuple(joints)
        if joints is not None
        else tuple(name for name in outward_names(plant) if name not in facts.mimics)
    )
    if not names:
        raise RobotError(f"{source}: no revolute or prismatic joint to identify")
    _check_names(str(source), names, movable)
    if joints is not None:
        _check_mimics(str(source), names, facts.mimics, movable)
    held = _check_locked(str(source), locked or {}, names, movable)
    tree = MergedTree(plant, names, held)
    return Robot(
        name=Path(source).stem,
        joints=tree.joints,
        parameters=tree.parameters,
        gravity=np.asarray(gravity, dtype=float),
        limits=_limits(plant, [movable[name] for name in names], facts),
        source=str(source),
        locked=tuple(held),
        locked_at=tuple(held.values()),
        inertia_faults=tuple(f for link, f in facts.faults.items() if link in tree.carried),
    )


def arm_joints(source: str | Path) -> tuple[str, ...]:
    """Names of the joints of the arm proper, from the base to where a hand branches off.

    At a fork the walk follows the side with the most moving joints; it ends where that
    side moves two joints or fewer beyond the fork (the fingers of a gripper), or at a tie.
    """
    if str(source).startswith("builtin:"):
        return load_robot(source).joint_names
    plant = load_plant(source)
    names = outward_names(plant)  # fingers that mimic one another fork like others
    tree = MergedTree(plant, names, held={})
    children = {
        i: [c for c in range(len(names)) if tree.joints[c].parent == i]
        for i in range(-1, len(names))
    }

    def moving(joint: int) -> int:
        return 1 + sum(moving(child) for child in children[joint])

    arm: list[int] = []
    ahead = children[-1]
    while ahead:
        ahead = sorted(ahead, key=moving, reverse=True)
        is_fork = len(ahead) > 1
        if is_fork and arm and (moving(ahead[0]) <= 2 or moving(ahead[0]) == moving(ahead[1])):
            break
        arm.append(ahead[0])
        ahead = children[ahead[0]]
    return tuple(names[i] for i in arm)


def _builtin(source: str, joints: Sequence[str] | None, gravity: Float[ndarray, "3"]) -> Robot:
    name = source.removeprefix("builtin:")
    if name not in BUILTIN_ROBOTS:
        raise RobotError(f"no built-in robot {name!r}; there are {sorted(BUILTIN_ROBOTS)}")
    robot = BUILTIN_ROBOTS[name]()
    if joints is not None and tuple(joints) != robot.joint_names:
        raise RobotError(f"{source}: its joints are {robot.joint_names}, not {tuple(joints)}")
    return robot.with_gravity(gravity)


def _check_names(source: str, names: Sequence[str], movable: Mapping[str, DrakeJoint]) -> None:
    for name in names:
        if name not in movable:
            raise RobotError(f"{source}: no joint {name!r}; its joints are {sorted(movable)}")
    if len(set(names)) != len(names):
        raise RobotError(f"{source}: a joint is named twice in {tuple(names)}")


def _check_mimics(
    source: str,
    names: Sequence[str],
    mimics: Mapping[str, str],
    movable: Mapping[str, DrakeJoint],
) -> None:
    """Joints that move together have no place in the model: neither may be active."""
    for follower, leader in mimics.items():
        if follower in names or (leader in names and follower in movable):
            raise RobotError(
                f"{source}: joint {follower!r} mimics {leader!r}, and joints that move together "
                f"are not modelled: leave out {follower!r} and {leader!r}, or make {follower!r} "
                "`fixed` in the file if what it moves weighs little"
            )


def _check_locked(
    source: str,
    locked: Mapping[str, float],
    names: Sequence[str],
    movable: Mapping[str, DrakeJoint],
) -> dict[str, float]:
    for name in locked:
        if name in names or name not in movable:
            raise RobotError(f"{source}: cannot lock {name!r}: it is active or does not exist")
    return {name: float(locked.get(name, 0.0)) for name in movable if name not in names}


def _limits(plant: MultibodyPlant, joints: Sequence[DrakeJoint], facts: UrdfFacts) -> JointLimits:
    def bounds(lower: str, upper: str) -> np.ndarray:
        return np.array([[getattr(j, lower)()[0], getattr(j, upper)()[0]] for j in joints])

    # Drake keeps a URDF's effort limits only where a transmission is declared.
    actuators = [plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices()]
    effort = {actuator.joint().name(): actuator.effort_limit() for actuator in actuators}
    effort |= facts.effort
    largest = np.array([effort.get(joint.name(), np.inf) for joint in joints])
    # A file that leaves a limit out often writes 0, which would forbid all motion.
    largest[largest == 0.0] = np.inf
    read = {
        kind: bounds(f"{kind}_lower_limits", f"{kind}_upper_limits")
        for kind in ("position", "velocity", "acceleration")
    }
    for bound in read.values():
        bound[bound[:, 0] >= bound[:, 1]] = (-np.inf, np.inf)
    return JointLimits.unlimited(len(joints)).with_(
        **read, torque=np.stack([-largest, largest], axis=1)
    )
