"""Robots from files of any format: kinematics, inertia and limits, nothing else."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint as DrakeJoint
from pydrake.multibody.tree import WeldJoint

from oed.errors import RobotError
from oed.robot.arm_chain import ArmChain, find_arm
from oed.robot.builtin import BUILTIN_ROBOTS
from oed.robot.description import RobotDescription
from oed.robot.limits import JointLimits
from oed.robot.merged_tree import MergedTree
from oed.robot.mimics import Mimic, held_position
from oed.robot.robot import Robot
from oed.robot.robot_file import is_movable, joints_of, open_robot, outward_names
from oed.robot.size_check import check_sizes

EARTH_GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2]


def load_robot(
    source: str | Path,
    *,
    joints: Sequence[str] | None = None,
    locked: Mapping[str, float] | None = None,
    gravity: Sequence[float] = EARTH_GRAVITY,
    place: Path | None = None,
) -> Robot:
    """Load a fixed-base arm.

    Args:
        source: URDF, xacro, SDF, MJCF or Denavit-Hartenberg file (`read_description`), or "builtin:NAME".
        joints: Names of the active joints in the order of the columns, the others being held; if
            None all that move and do not mimic another, from the base outward.
        locked: Position [rad or m] of held joints; 0, or where its leader has it, if not given.
        gravity: In the base frame [m/s^2].
        place: The file that this one is a copy of, see `read_description`.

    Returns:
        The robot; its `notes` say what was replaced, fixed or assumed, its `description` is for others.

    Raises:
        RobotError: If the file cannot be read, contradicts itself, or lacks a joint that was named.
    """
    if str(source).startswith("builtin:"):
        return _builtin(str(source), joints, np.asarray(gravity, dtype=float))
    description, plant = open_robot(source, place=place)
    return _of_plant(description, plant, joints, locked or {}, np.asarray(gravity, dtype=float))


def load_arm(
    source: str | Path,
    *,
    joints: Sequence[str] = (),
    gravity: Sequence[float] = EARTH_GRAVITY,
) -> Robot:
    """Load an arm: the named joints, or those from the base to where a hand branches off.

    Of several arms in one file the longest is taken, the first of equals; its notes name the others.

    Args:
        source: A robot's file of any format that `load_robot` reads, or "builtin:NAME".
        joints: Names of the active joints, in the order of the columns; the arm's if empty.
        gravity: (3,) in the base frame [m/s^2].

    Returns:
        The robot; its `notes` say what was replaced, fixed or assumed.

    Raises:
        RobotError: If the file cannot be read, contradicts itself, or lacks a joint that was named.
    """
    if joints or str(source).startswith("builtin:"):
        return load_robot(source, joints=tuple(joints) or None, gravity=gravity)
    description, plant = open_robot(source)
    arm = _arm(description, plant)
    robot = _of_plant(description, plant, arm.names, {}, np.asarray(gravity, dtype=float))
    return dataclasses.replace(robot, notes=(*arm.notes, *robot.notes))


def arm_joints(source: str | Path) -> tuple[str, ...]:
    """Names of the joints of the arm proper, from the base to where a hand branches off."""
    if str(source).startswith("builtin:"):
        return load_robot(source).joint_names
    return _arm(*open_robot(source)).names


def described(robot: Robot) -> RobotDescription:
    """What other programs must be given of a robot.

    Raises:
        RobotError: If it is a built-in one, which has no file.
    """
    if robot.description is None:
        raise RobotError(f"{robot.source or robot.name} does not come from a file")
    return robot.description


def _arm(description: RobotDescription, plant: MultibodyPlant) -> ArmChain:
    # Fingers that mimic one another fork like others, and a follower is commanded by its leader alone.
    names = outward_names(plant)
    _check_any(description, names)
    tree = _tree(description, plant, names, {})
    arm = find_arm(names, [joint.parent for joint in tree.joints])
    led, *others = (
        tuple(name for name in chain if name not in description.mimics)
        for chain in (arm.names, *arm.others)
    )
    return dataclasses.replace(arm, names=led, others=tuple(others))


def _of_plant(
    description: RobotDescription,
    plant: MultibodyPlant,
    joints: Sequence[str] | None,
    locked: Mapping[str, float],
    gravity: Float[ndarray, "3"],
) -> Robot:
    where, mimics = str(description.path), description.mimics
    movable = {joint.name(): joint for joint in joints_of(plant) if is_movable(joint)}
    names = (
        tuple(joints)
        if joints is not None
        else tuple(name for name in outward_names(plant) if name not in mimics)
    )
    _check_any(description, names)
    _check_names(where, names, movable)
    held = _held(where, locked, names, movable, mimics)
    tree = _tree(description, plant, names, held)
    _check_loops(description, tree)
    check_sizes(where, tree)
    faults = tuple(f for link, f in description.faults.items() if link in tree.carried)
    return Robot(
        name=description.path.stem,
        joints=tree.joints,
        parameters=tree.parameters,
        gravity=gravity,
        limits=_limits(plant, [movable[name] for name in names], description.effort),
        source=str(description.source),
        locked=tuple(held),
        locked_at=tuple(held.values()),
        inertia_faults=faults,
        description=description,
        notes=(
            *description.notes,
            *(fault.replacement for fault in faults),
            *_mimic_notes(names, held, mimics),
            *_free_notes(where, plant, tree),
        ),
    )


def _tree(
    description: RobotDescription,
    plant: MultibodyPlant,
    names: Sequence[str],
    held: Mapping[str, float],
) -> MergedTree:
    try:
        return MergedTree(plant, names, held)
    except (RobotError, RuntimeError) as error:  # such as two models' joints of one name
        raise RobotError(f"{description.path}: {error}") from error


def _builtin(source: str, joints: Sequence[str] | None, gravity: Float[ndarray, "3"]) -> Robot:
    name = source.removeprefix("builtin:")
    if name not in BUILTIN_ROBOTS:
        raise RobotError(f"no built-in robot {name!r}; there are {sorted(BUILTIN_ROBOTS)}")
    robot = BUILTIN_ROBOTS[name]()
    if joints is not None and tuple(joints) != robot.joint_names:
        raise RobotError(f"{source}: its joints are {robot.joint_names}, not {tuple(joints)}")
    return robot.with_gravity(gravity)


def _check_any(description: RobotDescription, names: Sequence[str]) -> None:
    if not names:
        raise RobotError(f"{description.path}: no revolute or prismatic joint to identify")


def _check_names(where: str, names: Sequence[str], movable: Mapping[str, DrakeJoint]) -> None:
    for name in names:
        if name not in movable:
            raise RobotError(f"{where}: no joint {name!r}; its joints are {sorted(movable)}")
    if len(set(names)) != len(names):
        raise RobotError(f"{where}: a joint is named twice in {tuple(names)}")


def _held(
    where: str,
    locked: Mapping[str, float],
    names: Sequence[str],
    movable: Mapping[str, DrakeJoint],
    mimics: Mapping[str, Mimic],
) -> dict[str, float]:
    """Where each joint that is not active stands [rad or m]."""
    for name in locked:
        if name in names or name not in movable:
            raise RobotError(f"{where}: cannot lock {name!r}: it is active or does not exist")
        _check_position(where, movable[name], locked[name])
    return {name: held_position(name, mimics, locked) for name in movable if name not in names}


def _check_position(where: str, joint: DrakeJoint, position: float) -> None:
    """Refuse a position that is beyond a joint's range by more than the range: of another unit."""
    lower, upper = joint.position_lower_limits()[0], joint.position_upper_limits()[0]
    beyond = max(lower - position, position - upper)
    if lower < upper and not beyond <= upper - lower:
        raise RobotError(
            f"{where}: cannot hold {joint.name()!r} at {position:g}: its range is {lower:.4g} to "
            f"{upper:.4g} rad or m"
        )


def _mimic_notes(
    names: Sequence[str], held: Mapping[str, float], mimics: Mapping[str, Mimic]
) -> tuple[str, ...]:
    """On followers that do not do as the file says."""
    notes = []
    for follower, mimic in mimics.items():
        if follower in names:
            notes.append(
                f"joint {follower!r} mimics {mimic.leader!r} in the file: it was named, and is "
                "taken as a joint of its own"
            )
        elif mimic.leader in names and follower in held:
            notes.append(
                f"joint {follower!r} mimics {mimic.leader!r}: it is held at {held[follower]:g}, "
                f"and what it carries moves with {mimic.leader!r} only where that carries it"
            )
    return tuple(notes)


def _free_notes(where: str, plant: MultibodyPlant, tree: MergedTree) -> tuple[str, ...]:
    """On joints of other kinds, which are held where the file has them if nothing moves them."""
    notes = []
    for joint in joints_of(plant):
        if is_movable(joint) or isinstance(joint, WeldJoint):
            continue
        if joint.parent_body().name() in tree.carried:
            raise RobotError(
                f"{where}: joint {joint.name()!r} is {joint.type_name()} and hangs from a joint "
                "that moves: only revolute and prismatic ones can be modelled inside a chain; make "
                "it fixed, or remove what it carries"
            )
        notes.append(f"joint {joint.name()!r} is {joint.type_name()}: it is held still")
    return tuple(notes)


def _check_loops(description: RobotDescription, tree: MergedTree) -> None:
    """Bodies that are tied to each other must not move against each other."""
    for first, second in description.loops:
        if _carrier(description, tree, first) != _carrier(description, tree, second):
            raise RobotError(
                f"{description.path}: bodies {first!r} and {second!r} are tied to each other: that "
                "is a closed loop, and only open chains can be modelled; choose joints that do not "
                "move them against each other, or remove the tie"
            )


def _carrier(description: RobotDescription, tree: MergedTree, body: str) -> int:
    try:
        return tree.carrier(body)
    except RobotError as error:
        raise RobotError(f"{description.path}: a tie of two bodies: {error}") from error


def _limits(
    plant: MultibodyPlant, joints: Sequence[DrakeJoint], stated: Mapping[str, float]
) -> JointLimits:
    def bounds(lower: str, upper: str) -> np.ndarray:
        return np.array([[getattr(j, lower)()[0], getattr(j, upper)()[0]] for j in joints])

    # Drake keeps a URDF's effort limits only where a transmission is declared.
    actuators = [plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices()]
    effort = {actuator.joint().name(): actuator.effort_limit() for actuator in actuators}
    effort |= stated
    largest = np.array([effort.get(joint.name(), np.inf) for joint in joints])
    # A file that leaves a limit out often writes 0, which would forbid all motion.
    largest[largest == 0.0] = np.inf
    read = {
        kind: bounds(f"{kind}_lower_limits", f"{kind}_upper_limits")
        for kind in ("position", "velocity", "acceleration")
    }
    position = read["position"]
    # Equal and not zero: a joint that the file holds there. Bounds next to it say so.
    is_held = (position[:, 0] == position[:, 1]) & (position[:, 0] != 0.0)
    position[is_held] = np.nextafter(position[is_held], [-np.inf, np.inf])
    for bound in read.values():
        bound[bound[:, 0] >= bound[:, 1]] = (-np.inf, np.inf)
    return JointLimits.unlimited(len(joints)).with_(
        **read, torque=np.stack([-largest, largest], axis=1)
    )
