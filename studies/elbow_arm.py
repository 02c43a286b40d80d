"""A six-joint elbow arm of the size of a UR5, with bodies and friction that are known."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.robot import Joint, JointLimits, Robot
from oed.robot.inertia import parameters_from_pseudo_inertia

GRAVITY = (0.0, 0.0, -9.81)
# A six-joint elbow arm of the size of a UR5: twist of each joint about x [rad], origin in the
# parent [m], then mass [kg], length and radius [m] of the cylinder that each link is.
GEOMETRY = (
    (0.0, (0.0, 0.0, 0.09), 3.7, 0.12, 0.06),
    (np.pi / 2, (0.0, 0.0, 0.0), 8.4, 0.42, 0.06),
    (0.0, (0.425, 0.0, 0.0), 2.3, 0.39, 0.05),
    (0.0, (0.392, 0.0, 0.11), 1.2, 0.1, 0.04),
    (np.pi / 2, (0.0, 0.095, 0.0), 1.2, 0.1, 0.04),
    (-np.pi / 2, (0.0, 0.08, 0.0), 0.4, 0.08, 0.04),
)
COULOMB = (8.0, 10.0, 6.0, 2.0, 2.0, 1.5)  # [N m]
VISCOUS = (12.0, 14.0, 8.0, 2.5, 2.0, 1.5)  # [N m s/rad]


def elbow_arm() -> Robot:
    """The arm; its limits bound random states to those of a quick motion."""
    joints, bodies = [], []
    for i, (twist, origin, mass, length, radius) in enumerate(GEOMETRY):
        c, s = np.round(np.cos(twist)), np.round(np.sin(twist))
        joints.append(
            Joint(
                name=f"joint_{i + 1}",
                kind="revolute",
                parent=i - 1,
                axis=np.array([0.0, 0.0, 1.0]),
                R_PJ=np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]),
                p_PJ=np.array(origin),
                link=f"link_{i + 1}",
                R_LJ=np.eye(3),
                p_LJ=np.zeros(3),
            )
        )
        bodies.append(_cylinder(mass, length, radius))
    n = len(GEOMETRY)
    limits = JointLimits.symmetric(
        position=(np.pi,) * n, velocity=(3.0,) * n, acceleration=(10.0,) * n
    )
    return Robot("elbow", tuple(joints), np.concatenate(bodies), np.array(GRAVITY), limits)


def _cylinder(mass: float, length: float, radius: float) -> Float[ndarray, "10"]:
    """A solid cylinder along x that begins at the origin, a little off the axis."""
    centre = np.array([length / 2, 0.1 * radius, 0.2 * radius])
    spread = np.diag([length**2 / 12, radius**2 / 4, radius**2 / 4])
    pseudo = np.empty((4, 4))
    pseudo[:3, :3] = mass * (spread + np.outer(centre, centre))
    pseudo[:3, 3] = pseudo[3, :3] = mass * centre
    pseudo[3, 3] = mass
    return parameters_from_pseudo_inertia(pseudo)
