"""A Drake plant of any of our robots: an independent second opinion on the dynamics."""

# pydrake's stubs want float64 arrays where ndarray is given, and lose the types of systems.
# pyright: reportArgumentType=false, reportCallIssue=false, reportReturnType=false
# pyright: reportIncompatibleMethodOverride=false, reportIndexIssue=false

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    MultibodyForces,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    SpatialInertia,
    UnitInertia,
)

from oed.dynamics.motion import Motion
from oed.robot import Robot
from oed.robot.inertia import inertia_tensor


def add_robot(plant: MultibodyPlant, robot: Robot, *, actuated: bool = False) -> None:
    """Add the bodies and joints of a robot, and its gravity, to an unfinished plant.

    Joint i of the plant is joint i of the robot; its body is called "body_<joint name>".

    Args:
        plant: Not yet finalised.
        robot: Its bodies need a positive mass; Drake divides moments by it.
        actuated: Whether each joint gets an actuator.

    Raises:
        ValueError: If a body has no positive mass, or one that no matter can have.
    """
    plant.mutable_gravity_field().set_gravity_vector(robot.gravity)
    bodies: dict[int, RigidBody] = {-1: plant.world_body()}
    joints = {}
    for i in robot.outward:
        joint = robot.joints[i]
        body = plant.AddRigidBody(
            f"body_{joint.name}",
            _spatial_inertia(robot.parameters[10 * i : 10 * i + 10], joint.name),
        )
        pose = RigidTransform(RotationMatrix(joint.R_PJ), joint.p_PJ)
        mount = plant.AddFrame(
            FixedOffsetFrame(f"mount_{joint.name}", bodies[joint.parent].body_frame(), pose)
        )
        kind = RevoluteJoint if joint.kind == "revolute" else PrismaticJoint
        joints[i] = plant.AddJoint(
            kind(joint.name, mount, body.body_frame(), joint.axis, damping=0.0)
        )
        bodies[i] = body
    if actuated:
        for i in range(robot.n):
            plant.AddJointActuator(robot.joints[i].name, joints[i])


def build_plant(robot: Robot) -> MultibodyPlant:
    """A finished continuous-time plant of the robot alone."""
    plant = MultibodyPlant(time_step=0.0)
    add_robot(plant, robot)
    plant.Finalize()
    return plant


def drake_torque(robot: Robot, motion: Motion) -> Float[ndarray, "samples joints"]:
    """Inverse dynamics by Drake, for comparison with `rigid_body_torque` [N m or N]."""
    plant = build_plant(robot)
    context = plant.CreateDefaultContext()
    order = coordinate_order(plant, robot)
    forces = MultibodyForces(plant)
    torque = np.zeros_like(motion.q)
    for k in range(len(motion)):
        plant.SetPositions(context, _scatter(motion.q[k], order))
        plant.SetVelocities(context, _scatter(motion.dq[k], order))
        plant.CalcForceElementsContribution(context, forces)
        found = plant.CalcInverseDynamics(context, _scatter(motion.ddq[k], order), forces)
        torque[k] = found[order]
    return torque


def coordinate_order(plant: MultibodyPlant, robot: Robot) -> list[int]:
    """Index in the plant's vectors of each of the robot's joints."""
    return [plant.GetJointByName(name).velocity_start() for name in robot.joint_names]


def _scatter(values: Float[ndarray, " joints"], order: list[int]) -> Float[ndarray, " joints"]:
    placed = np.zeros(len(values))
    placed[order] = values
    return placed


def _spatial_inertia(parameters: Float[ndarray, "10"], name: str) -> SpatialInertia:
    mass = float(parameters[0])
    if not mass > 0:
        raise ValueError(f"body of joint {name!r} has mass {mass:g} kg: Drake needs m > 0")
    unit = inertia_tensor(parameters) / mass
    try:
        return SpatialInertia(
            mass,
            parameters[1:4] / mass,
            UnitInertia(*np.diag(unit), unit[0, 1], unit[0, 2], unit[1, 2]),
        )
    except RuntimeError as error:
        raise ValueError(
            f"body of joint {name!r} has an inertia that no matter can have: {error}"
        ) from error
