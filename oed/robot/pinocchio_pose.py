"""A robot's file in Pinocchio, and where its held joints are as Pinocchio counts joints."""

from __future__ import annotations

import numpy as np
import pinocchio
from jaxtyping import Float
from numpy import ndarray

from oed.errors import RobotError
from oed.robot.description import RobotDescription
from oed.robot.robot import Robot


def pinocchio_model(description: RobotDescription) -> pinocchio.Model:
    """Pinocchio's model of a URDF.

    Raises:
        RobotError: If Pinocchio cannot read what Drake can.
    """
    try:
        return pinocchio.buildModelFromXML(description.text)
    except (ValueError, RuntimeError) as error:
        raise RobotError(f"{description.path}: Pinocchio cannot read this file: {error}") from error


def held_displacement(model: pinocchio.Model, robot: Robot) -> Float[ndarray, " velocities"]:
    """Displacement from the neutral posture that brings each held joint to its place.

    One entry a degree of freedom: Pinocchio keeps a continuous joint's position as cosine and
    sine, which `pinocchio.integrate` makes of it.
    """
    displacement = np.zeros(model.nv)
    for name, position in robot.held.items():
        displacement[model.joints[model.getJointId(name)].idx_v] = position
    return displacement
