"""Robots from URDF, SDF and MJCF, read by Drake's own Parser.

Only kinematics and inertia are taken, so meshes are never looked for: a plant
without a scene graph leaves them unread.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    WeldJoint,
)
from pydrake.multibody.tree import Joint as DrakeJoint

from oed.errors import RobotError
from oed.robot.builtin import BUILTIN_ROBOTS
from oed.robot.inertia import transform_parameters
from oed.robot.limits import JointLimits
from oed.robot.robot import Joint, Robot

SUFFIXES = (".urdf", ".sdf", ".xml", ".mjcf")
EARTH_GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2]
# Rotation entries this close to 0 or 1 are rounding of the file's roll, pitch and yaw.
ROUNDING = 1e-14


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
            and prismatic joints, from the base outward. The others are held still.
        locked: Position [rad or m] at which a joint is held; 0 if not given.
        gravity: In the base frame [m/s^2].

    Raises:
        RobotError: If the file cannot be read or lacks a joint that was named.
    """
    if str(source).startswith("builtin:"):
        return _builtin(str(source), joints, np.asarray(gravity, dtype=float))
    plant = load_plant(source)
    movable = {joint.name(): joint for joint in _joints(plant) if _is_movable(joint)}
    names = tuple(joints) if joints is not None else _outward_names(plant)
    if not names:
        raise RobotError(f"{source}: no revolute or prismatic joint to identify")
    _check_names(str(source), names, movable)
    held = _check_locked(str(source), locked or {}, names, movable)
    tree = _MergedTree(plant, names, held)
    return Robot(
        name=Path(source).stem,
        joints=tree.joints,
        parameters=tree.parameters,
        gravity=np.asarray(gravity, dtype=float),
        limits=_limits(plant, [movable[name] for name in names], Path(source)),
        source=str(source),
        locked=tuple(name for name in movable if name not in names),
    )


def load_plant(source: str | Path) -> MultibodyPlant:
    """Parse a file into a finalized continuous plant whose base is welded to the world."""
    path = Path(source)
    if not path.is_file():
        raise RobotError(f"{path}: no such robot file; give a URDF, SDF or MJCF file")
    if path.suffix.lower() not in SUFFIXES:
        raise RobotError(
            f"{path}: unknown kind of robot file; expected one of {SUFFIXES}"
        )
    plant = MultibodyPlant(time_step=0.0)
    # The parser warns about transmissions, mimic joints and cameras, none of which matter here.
    drake_log = logging.getLogger("drake")
    level = drake_log.level
    drake_log.setLevel(logging.ERROR)
    try:
        Parser(plant).AddModels(str(path))
    except RuntimeError as error:
        raise RobotError(f"{path}: Drake cannot read this file: {error}") from error
    finally:
        drake_log.setLevel(level)
    weld_free_bodies(plant)
    plant.Finalize()
    return plant


def weld_free_bodies(plant: MultibodyPlant) -> None:
    """Fix every body that no joint carries to the world: an arm stands on its base."""
    carried = {joint.child_body().index() for joint in _joints(plant)}
    for body in _bodies(plant):
        if body.index() != plant.world_body().index() and body.index() not in carried:
            plant.WeldFrames(plant.world_frame(), body.body_frame())


def arm_joints(source: str | Path) -> tuple[str, ...]:
    """Names of the joints of the arm proper, from the base to where a hand branches off.

    At a fork the walk follows the side with the most moving joints; it ends where that
    side moves two joints or fewer beyond the fork (the fingers of a gripper), or at a tie.
    """
    if str(source).startswith("builtin:"):
        return load_robot(source).joint_names
    robot = load_robot(source)
    children = {
        i: [c for c in range(robot.n) if robot.joints[c].parent == i]
        for i in range(-1, robot.n)
    }

    def moving(joint: int) -> int:
        return 1 + sum(moving(child) for child in children[joint])

    arm: list[int] = []
    ahead = children[-1]
    while ahead:
        ahead = sorted(ahead, key=moving, reverse=True)
        is_fork = len(ahead) > 1
        if (
            is_fork
            and arm
            and (moving(ahead[0]) <= 2 or moving(ahead[0]) == moving(ahead[1]))
        ):
            break
        arm.append(ahead[0])
        ahead = children[ahead[0]]
    return tuple(robot.joint_names[i] for i in arm)


def _builtin(source: str, joints: Sequence[str] | None, gravity: np.ndarray) -> Robot:
    name = source.removeprefix("builtin:")
    if name not in BUILTIN_ROBOTS:
        raise RobotError(
            f"no built-in robot {name!r}; there are {sorted(BUILTIN_ROBOTS)}"
        )
    robot = BUILTIN_ROBOTS[name]()
    if joints is not None and tuple(joints) != robot.joint_names:
        raise RobotError(
            f"{source}: its joints are {robot.joint_names}, not {tuple(joints)}"
        )
    return robot.with_gravity(gravity)


def _joints(plant: MultibodyPlant) -> list[DrakeJoint]:
    return [plant.get_joint(index) for index in plant.GetJointIndices()]


def _bodies(plant: MultibodyPlant) -> list[RigidBody]:
    return [plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies())]


def _is_movable(joint: DrakeJoint) -> bool:
    return isinstance(joint, RevoluteJoint | PrismaticJoint)


def _check_names(
    source: str, names: Sequence[str], movable: Mapping[str, DrakeJoint]
) -> None:
    for name in names:
        if name not in movable:
            raise RobotError(
                f"{source}: no joint {name!r}; its joints are {sorted(movable)}"
            )
    if len(set(names)) != len(names):
        raise RobotError(f"{source}: a joint is named twice in {tuple(names)}")


def _check_locked(
    source: str,
    locked: Mapping[str, float],
    names: Sequence[str],
    movable: Mapping[str, DrakeJoint],
) -> dict[str, float]:
    for name in locked:
        if name in names or name not in movable:
            raise RobotError(
                f"{source}: cannot lock {name!r}: it is active or does not exist"
            )
    return {name: float(locked.get(name, 0.0)) for name in movable if name not in names}


def _outward_names(plant: MultibodyPlant) -> tuple[str, ...]:
    """Movable joints branch by branch from the base, whatever the file's order."""
    inboard: dict[int, list[DrakeJoint]] = {}
    for joint in _joints(plant):
        inboard.setdefault(int(joint.parent_body().index()), []).append(joint)

    def beyond(body: int) -> list[str]:
        names: list[str] = []
        for joint in inboard.get(body, []):
            names += [joint.name()] if _is_movable(joint) else []
            names += beyond(int(joint.child_body().index()))
        return names

    return tuple(beyond(int(plant.world_body().index())))


class _MergedTree:
    """The active joints and, for each, the merged inertia of all that it carries."""

    def __init__(
        self, plant: MultibodyPlant, names: Sequence[str], held: Mapping[str, float]
    ) -> None:
        self._plant = plant
        self._context = plant.CreateDefaultContext()
        for name, position in held.items():
            joint = plant.GetJointByName(name)
            (
                joint.set_angle
                if isinstance(joint, RevoluteJoint)
                else joint.set_translation
            )(self._context, position)
        self._column = {name: i for i, name in enumerate(names)}
        # Per body: the active joint that carries it and the body's pose in that joint's frame.
        self._carrier: dict[int, tuple[int, RigidTransform]] = {
            int(plant.world_body().index()): (-1, RigidTransform())
        }
        found: dict[int, Joint] = {}
        pending = _joints(plant)
        while pending:
            ready = [
                j for j in pending if int(j.parent_body().index()) in self._carrier
            ]
            if not ready:
                raise RobotError(
                    f"joints {[j.name() for j in pending]} hang from no base"
                )
            for joint in ready:
                self._place(joint, found)
            pending = [j for j in pending if j not in ready]
        self.joints = tuple(found[i] for i in range(len(names)))
        self.parameters = self._merge_inertia(len(names))

    def _place(self, joint: DrakeJoint, found: dict[int, Joint]) -> None:
        parent, X_CP = self._carrier[int(joint.parent_body().index())]
        X_CF = X_CP @ joint.frame_on_parent().GetFixedPoseInBodyFrame()
        X_BM = joint.frame_on_child().GetFixedPoseInBodyFrame()
        child = int(joint.child_body().index())
        column = self._column.get(joint.name())
        if column is None or not _is_movable(joint):
            X_FM = self._held_pose(joint)
            self._carrier[child] = (parent, X_CF @ X_FM @ X_BM.inverse())
            return
        is_revolute = isinstance(joint, RevoluteJoint)
        axis = joint.revolute_axis() if is_revolute else joint.translation_axis()
        found[column] = Joint(
            name=joint.name(),
            kind="revolute" if is_revolute else "prismatic",
            parent=parent,
            axis=_without_rounding(axis),
            R_PJ=_without_rounding(X_CF.rotation().matrix()),
            p_PJ=X_CF.translation(),
            link=joint.child_body().name(),
            R_LJ=X_BM.rotation().matrix(),
            p_LJ=X_BM.translation(),
        )
        self._carrier[child] = (column, X_BM.inverse())

    def _held_pose(self, joint: DrakeJoint) -> RigidTransform:
        if isinstance(joint, WeldJoint):
            return joint.X_FM()
        return joint.frame_on_child().CalcPose(self._context, joint.frame_on_parent())

    def _merge_inertia(self, joints: int) -> np.ndarray:
        parameters = np.zeros((joints, 10))
        for body in _bodies(self._plant):
            carrier, X_CB = self._carrier[int(body.index())]
            if carrier >= 0:
                parameters[carrier] += transform_parameters(
                    _body_parameters(body), X_CB.rotation().matrix(), X_CB.translation()
                )
        return parameters.reshape(-1)


def _body_parameters(body: RigidBody) -> np.ndarray:
    spatial = body.default_spatial_inertia()
    mass = spatial.get_mass()
    if not np.isfinite(mass) or mass == 0.0:
        return np.zeros(10)
    inertia = spatial.CalcRotationalInertia()
    moments, products = inertia.get_moments(), inertia.get_products()
    xx, yy, zz = moments
    xy, xz, yz = products
    return np.array([mass, *(mass * spatial.get_com()), xx, xy, xz, yy, yz, zz])


def _without_rounding(entries: np.ndarray) -> np.ndarray:
    """Make entries within rounding of 0 and +-1 exact, so that products with them vanish."""
    nearest = np.round(entries)
    return np.where(np.abs(entries - nearest) < ROUNDING, nearest, entries)


def _limits(
    plant: MultibodyPlant, joints: Sequence[DrakeJoint], path: Path
) -> JointLimits:
    def bounds(lower: str, upper: str) -> np.ndarray:
        return np.array(
            [[getattr(j, lower)()[0], getattr(j, upper)()[0]] for j in joints]
        )

    effort = _effort_limits(plant, path)
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


def _effort_limits(plant: MultibodyPlant, path: Path) -> dict[str, float]:
    """Largest torque of each joint [N m].

    Drake keeps a URDF's effort limits only where a transmission is declared; Pinocchio
    keeps them always.
    """
    if path.suffix.lower() == ".urdf":
        import pinocchio

        model = pinocchio.buildModelFromUrdf(str(path))
        return {
            name: float(model.upperEffortLimit[model.joints[i].idx_v])
            for i, name in enumerate(model.names)
            if i > 0 and model.joints[i].nv == 1
        }
    actuators = [plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices()]
    return {actuator.joint().name(): actuator.effort_limit() for actuator in actuators}
