"""One question to three codes: the torque of a robot by Drake, by Pinocchio and by this package.

Newton-Euler, regressor times parameters and the CasADi function share their source; Drake and
Pinocchio share nothing with them but the file.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi
import numpy as np
import pinocchio
from jaxtyping import Float
from numpy import ndarray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces, RevoluteJoint
from pydrake.systems.framework import Context

from oed.dynamics.drake_plant import drake_torque
from oed.dynamics.effects import RigidBody
from oed.dynamics.motion import Motion, random_motion
from oed.dynamics.newton_euler import rigid_body_regressor, rigid_body_torque
from oed.dynamics.torque_model import TorqueModel
from oed.errors import RobotError
from oed.robot import Robot, described
from oed.robot.pinocchio_pose import held_displacement, pinocchio_model
from oed.robot.robot_file import load_plant

AGREEMENT = 1e-10  # of the largest torque: a thousand times what rounding explains


@dataclass(frozen=True)
class CrossCheck:
    """How far three of our torques are from Drake's, relative to the largest torque.

    Attributes:
        robot: Name of the robot.
        joints: Number of active joints.
        states: Number of random states compared.
        newton_euler: Worst relative disagreement of the recursion (2) with Drake.
        regressor: The same of regressor times parameters (4).
        casadi: The same of the CasADi function.
        pinocchio: The same of Pinocchio; None where the file is no URDF.
    """

    robot: str
    joints: int
    states: int
    newton_euler: float
    regressor: float
    casadi: float
    pinocchio: float | None

    @property
    def worst(self) -> float:
        """The largest of all."""
        return max(self.newton_euler, self.regressor, self.casadi, self.pinocchio or 0.0)

    @property
    def agrees(self) -> bool:
        """Whether all are within `AGREEMENT`."""
        return self.worst < AGREEMENT


def cross_check(robot: Robot, *, states: int = 200, seed: int = 0) -> CrossCheck:
    """Compare the inverse dynamics of a robot's bodies with Drake's at random states.

    Args:
        robot: With the inertial parameters of its file, in which impossible ones were replaced
            for all three programs alike; or a built-in one, of which Drake is given the bodies
            and joints.
        states: Number of states.
        seed: Of the random states.
    """
    motion = random_motion(robot, states, np.random.default_rng(seed))
    file = robot.description
    reference = drake_torque(robot, motion) if file is None else file_torque(robot, motion)
    is_urdf = file is not None and file.format == "urdf"
    largest = np.abs(reference).max()
    if largest == 0:
        raise RobotError(
            f"{robot.source}: all torques are 0: its bodies have no mass to compare by"
        )

    def disagreement(torque: Float[ndarray, "samples joints"]) -> float:
        return float(np.abs(torque - reference).max() / largest)

    return CrossCheck(
        robot=robot.name,
        joints=robot.n,
        states=states,
        newton_euler=disagreement(rigid_body_torque(robot, motion)),
        regressor=disagreement(rigid_body_regressor(robot, motion) @ robot.parameters),
        casadi=disagreement(_symbolic_torque(robot, motion)),
        pinocchio=disagreement(pinocchio_torque(robot, motion)) if is_urdf else None,
    )


def file_torque(robot: Robot, motion: Motion) -> Float[ndarray, "samples joints"]:
    """Torque by Drake's MultibodyPlant of the robot's own file, other joints where they are held.

    Rotor inertias that the file states are left out: a robot here is its bodies alone.
    """
    plant = load_plant(described(robot))
    plant.mutable_gravity_field().set_gravity_vector(robot.gravity)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
    context = plant.CreateDefaultContext()
    joints = [plant.GetJointByName(name) for name in robot.joint_names]
    for name, position in robot.held.items():
        joint = plant.GetJointByName(name)
        is_revolute = isinstance(joint, RevoluteJoint)
        (joint.set_angle if is_revolute else joint.set_translation)(context, position)
    for index in plant.GetJointActuatorIndices():
        plant.get_joint_actuator(index).SetRotorInertia(context, 0.0)
    positions = np.array([joint.position_start() for joint in joints])
    velocities = np.array([joint.velocity_start() for joint in joints])
    return _inverse_dynamics(plant, context, motion, positions, velocities)


def pinocchio_torque(robot: Robot, motion: Motion) -> Float[ndarray, "samples joints"]:
    """Torque by Pinocchio of the robot's own URDF, other joints where they are held."""
    model = pinocchio_model(described(robot))
    model.gravity.linear = robot.gravity
    data = model.createData()
    order = [model.joints[model.getJointId(name)].idx_v for name in robot.joint_names]
    rest = held_displacement(model, robot)
    torques = np.empty(motion.q.shape)
    for k in range(len(motion)):
        q, dq, ddq = rest.copy(), np.zeros(model.nv), np.zeros(model.nv)
        q[order], dq[order], ddq[order] = motion.q[k], motion.dq[k], motion.ddq[k]
        # A continuous joint is kept as cosine and sine: move there from zero.
        pose = pinocchio.integrate(model, pinocchio.neutral(model), q)
        torques[k] = pinocchio.rnea(model, data, pose, dq, ddq)[order]
    return torques


def _inverse_dynamics(
    plant: MultibodyPlant,
    context: Context,
    motion: Motion,
    positions: ndarray,
    velocities: ndarray,
) -> Float[ndarray, "samples joints"]:
    q_all = plant.GetPositions(context).copy()
    dq_all, ddq_all = np.zeros(plant.num_velocities()), np.zeros(plant.num_velocities())
    no_force = MultibodyForces(plant)
    torques = np.empty(motion.q.shape)
    for k, (q, dq, ddq) in enumerate(zip(motion.q, motion.dq, motion.ddq, strict=True)):
        q_all[positions], dq_all[velocities], ddq_all[velocities] = q, dq, ddq
        plant.SetPositions(context, q_all)
        plant.SetVelocities(context, dq_all)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
        total = plant.CalcInverseDynamics(context, ddq_all, no_force)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
        gravity = plant.CalcGravityGeneralizedForces(context)
        torques[k] = total[velocities] - gravity[velocities]
    return torques


def _symbolic_torque(robot: Robot, motion: Motion) -> Float[ndarray, "samples joints"]:
    model = TorqueModel(robot, (RigidBody(robot),))
    q, dq, ddq = (casadi.SX.sym(name, robot.n) for name in ("q", "dq", "ddq"))
    columns = model.symbolic_columns(q, dq, ddq, sign_width=0.0)
    torque = casadi.Function("torque", [q, dq, ddq], [columns @ robot.parameters])
    states = (motion.q.T, motion.dq.T, motion.ddq.T)
    return np.asarray(torque.map(len(motion))(*states)).T
