"""A robot with what a robot file can hold of its identified parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import RigidBody, with_columns
from oed.dynamics.effects.effect import JointTerm
from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import rigid_body_torque
from oed.dynamics.torque_model import TorqueModel
from oed.robot import Robot
from oed.robot.inertia import inertia_tensor, transform_parameters


@dataclass(frozen=True)
class CalibratedRobot:
    """Rigid bodies, joint friction and rotor inertia.

    Attributes:
        robot: With identified inertial parameters.
        coulomb: (n,) Coulomb friction [N m or N].
        viscous: (n,) viscous friction [N m s/rad or N s/m].
        rotor_inertia: (n,) seen at the joint [kg m^2 or kg].
        left_out: Names of identified parameters that no robot file has a place for.
    """

    robot: Robot
    coulomb: Float[ndarray, " joints"]
    viscous: Float[ndarray, " joints"]
    rotor_inertia: Float[ndarray, " joints"]
    left_out: tuple[str, ...] = ()

    @classmethod
    def of(cls, model: TorqueModel, parameters: Float[ndarray, " p"]) -> CalibratedRobot:
        """What a model's parameters say of the robot.

        Raises:
            ValueError: If the model's first effect is not its rigid body.
            NoUsableResult: If its torques are currents.
        """
        model.robot.require_newton_metres(model.robot.name)
        if not isinstance(model.effects[0], RigidBody):
            raise ValueError(  # noqa: TRY004  # of a value: the type is right
                "the first effect of the model must be its rigid body"
            )
        n = model.robot.n
        held = {term: np.zeros(n) for term in get_args(JointTerm)}
        left_out: list[str] = []
        for effect, place in list(with_columns(model.effects))[1:]:
            if effect.joint_term is None:
                left_out += [parameter.name for parameter in effect.parameters]
                continue
            (parameter,) = effect.parameters
            held[effect.joint_term][parameter.joint] += parameters[place.start]
        robot = model.robot.with_parameters(parameters[: 10 * n])
        dry, viscous, rotors = (held[term] for term in ("friction", "damping", "armature"))
        return cls(robot, dry, viscous, rotors, tuple(left_out))

    def smooth_torque(self, motion: Motion) -> Float[ndarray, "samples joints"]:
        """Torque without Coulomb friction, whose sign each simulator rounds in its own way."""
        drives = self.rotor_inertia * motion.ddq + self.viscous * motion.dq
        return rigid_body_torque(self.robot, motion) + drives


@dataclass(frozen=True)
class Inertial:
    """A body as robot files state it.

    Attributes:
        mass: [kg].
        com: (3,) centre of mass in the link frame [m].
        inertia: (3, 3) about the centre of mass, in the link's axes [kg m^2].
    """

    mass: float
    com: Float[ndarray, "3"]
    inertia: Float[ndarray, "3 3"]


def link_inertial(robot: Robot, joint: int, *, in_source_link: bool) -> Inertial:
    """Mass, centre and central inertia of the body that a joint carries.

    Args:
        robot: With its inertial parameters.
        joint: Index of the joint.
        in_source_link: Whether in the frame of the source file's link; else in the body frame.

    Raises:
        ValueError: If the body has no positive mass.
    """
    parameters = robot.parameters[10 * joint : 10 * joint + 10]
    carried = robot.joints[joint]
    if in_source_link:
        parameters = transform_parameters(parameters, carried.R_LJ, carried.p_LJ)
    mass = float(parameters[0])
    if not mass > 0:
        raise ValueError(f"{carried.link} has mass {mass:g} kg: robot files need a positive one")
    com = parameters[1:4] / mass
    shift = mass * (com @ com * np.eye(3) - np.outer(com, com))
    return Inertial(mass, com, inertia_tensor(parameters) - shift)
