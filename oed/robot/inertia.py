"""The ten standard inertial parameters of a link, and its pseudo-inertia.

The order is (m, mx, my, mz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz): mass, first moment
m s and inertia tensor Gamma, both about the link frame's origin and in its axes
(Calafiore 2001, section 2).
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

PARAMETER_SYMBOLS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
PARAMETER_UNITS = ("kg", *("kg m",) * 3, *("kg m^2",) * 6)


def inertia_tensor(parameters: Float[ndarray, "10"]) -> Float[ndarray, "3 3"]:
    """Inertia tensor about the frame origin [kg m^2]."""
    xx, xy, xz, yy, yz, zz = parameters[4:]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def pseudo_inertia(parameters: Float[ndarray, "10"]) -> Float[ndarray, "4 4"]:
    """Pseudo-inertia [[Sigma, h], [h', m]] with Sigma = tr(I)/2 - I.

    It is positive definite exactly when a distribution of positive mass has
    these parameters (Wensing, Kim, Slotine 2018, "Linear matrix inequalities for
    physically consistent inertial parameter identification").
    """
    inertia = inertia_tensor(parameters)
    moment = parameters[1:4]
    sigma = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    return np.block([[sigma, moment[:, None]], [moment[None, :], parameters[:1][None, :]]])


def parameters_from_pseudo_inertia(
    pseudo: Float[ndarray, "4 4"],
) -> Float[ndarray, "10"]:
    """Inverse of `pseudo_inertia`."""
    sigma = pseudo[:3, :3]
    inertia = np.trace(sigma) * np.eye(3) - sigma
    return np.concatenate([pseudo[3:, 3], pseudo[:3, 3], inertia[np.triu_indices(3)]])


def transform_parameters(
    parameters: Float[ndarray, "10"],
    rotation: Float[ndarray, "3 3"],
    origin: Float[ndarray, "3"],
) -> Float[ndarray, "10"]:
    """The same body's parameters in another frame.

    Args:
        parameters: In frame B.
        rotation: R_AB, the axes of B in frame A.
        origin: p_AB, the origin of B in frame A [m].
    """
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = origin
    return parameters_from_pseudo_inertia(pose @ pseudo_inertia(parameters) @ pose.T)
