"""Joint-space mass matrices at many poses, and whether they are ones."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import RotorInertia
from oed.dynamics.motion import UNBOUNDED_RANGE, Motion
from oed.dynamics.newton_euler import rigid_body_torque
from oed.dynamics.torque_model import TorqueModel


def mass_matrices(
    model: TorqueModel, parameters: Float[ndarray, " p"], q: Float[ndarray, "poses joints"]
) -> Float[ndarray, "poses joints joints"]:
    """M(q) of rigid body and rotors: column j is the torque of a unit acceleration of joint j.

    Args:
        model: Its first effect is the rigid body.
        parameters: In the model's order; need not be feasible.
        q: Poses [rad or m].
    """
    n = model.robot.n
    robot = model.robot.with_parameters(parameters[: 10 * n]).with_gravity(np.zeros(3))
    still, t = np.zeros_like(q), np.zeros(len(q))
    matrices = np.empty((len(q), n, n))
    for joint in range(n):
        unit = still.copy()
        unit[:, joint] = 1.0
        matrices[:, :, joint] = rigid_body_torque(robot, Motion(t, q, still, unit))
    return matrices + np.diag(_rotor_inertias(model, parameters))


def random_poses(
    model: TorqueModel, poses: int, rng: np.random.Generator
) -> Float[ndarray, "poses joints"]:
    """Poses drawn evenly within the joints' limits."""
    position = model.robot.limits.position
    lower = np.where(np.isfinite(position[:, 0]), position[:, 0], -UNBOUNDED_RANGE)
    upper = np.where(np.isfinite(position[:, 1]), position[:, 1], UNBOUNDED_RANGE)
    return rng.uniform(lower, upper, (poses, model.robot.n))


def share_positive_definite(matrices: Float[ndarray, "poses joints joints"]) -> float:
    """Share of the matrices that are positive definite, symmetric part."""
    symmetric = 0.5 * (matrices + matrices.transpose(0, 2, 1))
    return float(np.mean(np.linalg.eigvalsh(symmetric)[:, 0] > 0))


def _rotor_inertias(
    model: TorqueModel, parameters: Float[ndarray, " p"]
) -> Float[ndarray, " joints"]:
    rotor, column = np.zeros(model.robot.n), 0
    for effect in model.effects:
        if isinstance(effect, RotorInertia):
            rotor[effect.joint] += parameters[column]
        column += len(effect.parameters)
    return rotor
