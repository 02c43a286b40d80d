"""Robots that need no file."""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.robot.inertia import parameters_from_pseudo_inertia
from oed.robot.limits import JointLimits
from oed.robot.robot import Joint, Robot

IMI_LINK_LENGTHS = (0.359, 0.24)  # [m], Calafiore 2001, section 4
# Base parameters that the paper estimated on its J_k-optimal trajectory (section 5):
# Gamma_1z + m_2 l_1^2 [kg m^2], m_2 s_2x, m_2 s_2y [kg m], Gamma_2z [kg m^2].
IMI_BASE_PARAMETERS = (3.923, 0.808, 0.328, 0.141)
# Coulomb and viscous friction of both joints from the same estimate [N m, N m s/rad].
IMI_COULOMB = (2.61, 1.460)
IMI_VISCOUS = (7.343, 0.787)
# The torque depends on the four base parameters alone; the masses only complete a
# physically consistent arm, which needs m_2 Gamma_2z > |m_2 s_2|^2.
IMI_MASSES = (15.0, 6.0)  # [kg]


def imi_scara() -> Robot:
    """The paper's planar two-link arm with vertical axes (Calafiore 2001, section 4)."""
    total, first_x, first_y, inertia_2 = IMI_BASE_PARAMETERS
    mass_1, mass_2 = IMI_MASSES
    inertia_1 = total - mass_2 * IMI_LINK_LENGTHS[0] ** 2
    parameters = np.concatenate(
        [
            _parameters(mass_1, np.zeros(3), inertia_1),
            _parameters(mass_2, np.array([first_x, first_y, 0.0]), inertia_2),
        ]
    )
    joints = (
        _planar_joint("joint_1", parent=-1, offset=0.0),
        _planar_joint("joint_2", parent=0, offset=IMI_LINK_LENGTHS[0]),
    )
    return Robot(
        name="imi_scara",
        joints=joints,
        parameters=parameters,
        gravity=np.array([0.0, 0.0, -9.81]),
        limits=JointLimits.symmetric(
            position=(1.5, 1.5),  # [rad]
            velocity=(8.0, 8.0),  # [rad/s]
            acceleration=(5.0, 5.0),  # [rad/s^2]
        ),
        source="builtin:imi_scara",
    )


def _parameters(
    mass: float, moment: Float[ndarray, "3"], axial_inertia: float
) -> Float[ndarray, "10"]:
    """A body of that mass, first moment and Gamma_z, spread evenly about its centre."""
    second_moment = np.outer(moment, moment) / mass
    spread = (axial_inertia - second_moment[0, 0] - second_moment[1, 1]) / 2
    pseudo = np.zeros((4, 4))
    pseudo[:3, :3] = second_moment + spread * np.eye(3)
    pseudo[:3, 3] = pseudo[3, :3] = moment
    pseudo[3, 3] = mass
    return parameters_from_pseudo_inertia(pseudo)


def _planar_joint(name: str, parent: int, offset: float) -> Joint:
    return Joint(
        name=name,
        kind="revolute",
        parent=parent,
        axis=np.array([0.0, 0.0, 1.0]),
        R_PJ=np.eye(3),
        p_PJ=np.array([offset, 0.0, 0.0]),
        link=name.replace("joint", "link"),
        R_LJ=np.eye(3),
        p_LJ=np.zeros(3),
    )


BUILTIN_ROBOTS: dict[str, Callable[[], Robot]] = {"imi_scara": imi_scara}
