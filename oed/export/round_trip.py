"""What a written robot file computes, by two programs that did not write it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
from jaxtyping import Float
from numpy import ndarray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from oed.dynamics.drake_plant import coordinate_order
from oed.dynamics.motion import Motion, random_motion
from oed.errors import OedError
from oed.export.calibrated_robot import CalibratedRobot
from oed.robot import Robot
from oed.robot.robot_file import load_plant

AGREEMENT = 1e-9  # of the largest torque
STATES = 50  # at which a written file is asked for its torques


class ExportMismatch(OedError):
    """A file does not compute the torques of the robot that was written to it.

    Attributes:
        disagreement: Largest difference relative to the largest torque.
    """

    def __init__(self, message: str, disagreement: float) -> None:
        super().__init__(message)
        self.disagreement = disagreement


def require_round_trip(calibrated: CalibratedRobot, path: str | Path, motion: Motion) -> float:
    """Largest disagreement of Drake's torques from the file, relative to the largest torque.

    Raises:
        ExportMismatch: If it is not below `AGREEMENT`.
    """
    expected = calibrated.smooth_torque(motion)
    found = torque_by_drake(load_plant(path), calibrated, motion)
    disagreement = float(np.abs(found - expected).max() / np.abs(expected).max())
    if not disagreement < AGREEMENT:
        raise ExportMismatch(
            f"{Path(path).name}, as it would be written: torques from the file differ from the "
            f"model's by {disagreement:.1e} of the largest; nothing was written",
            disagreement,
        )
    return disagreement


def some_states(robot: Robot) -> Motion:
    """Random states within a robot's limits, the same each time."""
    return random_motion(robot, STATES, np.random.default_rng(0))


def torque_by_drake(
    plant: MultibodyPlant, calibrated: CalibratedRobot, motion: Motion
) -> Float[ndarray, "samples joints"]:
    """Inverse dynamics of a plant with its damping and rotors, no Coulomb friction [N m or N].

    Args:
        plant: Finished, with the robot's joints by name.
        calibrated: For joint order and gravity; none of its parameters is used.
        motion: N states.
    """
    robot = calibrated.robot
    plant.mutable_gravity_field().set_gravity_vector(robot.gravity)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
    context = plant.CreateDefaultContext()
    order = coordinate_order(plant, robot)
    forces = MultibodyForces(plant)
    q, dq, ddq = (np.zeros(plant.num_velocities()) for _ in range(3))
    torque = np.empty_like(motion.q)
    for k in range(len(motion)):
        q[order], dq[order], ddq[order] = motion.q[k], motion.dq[k], motion.ddq[k]
        plant.SetPositions(context, q)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
        plant.SetVelocities(context, dq)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
        # Gravity, and the damping of joints with it.
        plant.CalcForceElementsContribution(context, forces)
        total = plant.CalcInverseDynamics(context, ddq, forces)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
        torque[k] = total[order]
    return torque


def torque_by_pinocchio(
    path: str | Path, calibrated: CalibratedRobot, motion: Motion
) -> Float[ndarray, "samples joints"]:
    """Rigid-body torque by Pinocchio, with damping and friction as it read them [N m or N].

    URDF has no place for rotor inertia that Pinocchio reads: the robot's own is added there.

    Args:
        path: Of a URDF or MJCF file.
        calibrated: For joint order, gravity and, with URDF, rotors.
        motion: N states.
    """
    robot, path = calibrated.robot, Path(path)
    is_urdf = path.suffix.lower() == ".urdf"
    build = pinocchio.buildModelFromUrdf if is_urdf else pinocchio.buildModelFromMJCF
    model = build(str(path))
    model.gravity.linear = robot.gravity
    index = [model.joints[model.getJointId(name)] for name in robot.joint_names]
    place = [joint.idx_v for joint in index]
    if is_urdf:
        armature = np.zeros(model.nv)
        armature[place] = calibrated.rotor_inertia
        model.armature = armature
    data = model.createData()
    torque = np.empty_like(motion.q)
    for k in range(len(motion)):
        q = pinocchio.neutral(model)
        for joint, value in zip(index, motion.q[k], strict=True):
            # A joint without limits turns on the circle: Pinocchio keeps cosine and sine.
            circle = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
            q[joint.idx_q : joint.idx_q + joint.nq] = circle
        dq, ddq = np.zeros(model.nv), np.zeros(model.nv)
        dq[place], ddq[place] = motion.dq[k], motion.ddq[k]
        rigid = pinocchio.rnea(model, data, q, dq, ddq)
        torque[k] = (rigid + model.damping * dq)[place]
    return torque
