"""Whether a model's bodies can exist, which every robot file and simulator asks for."""

from __future__ import annotations

import numpy as np

from oed.dynamics.online import Offline
from oed.errors import NoUsableResult
from oed.export.calibrated_robot import CalibratedRobot
from oed.export.effect_torque import not_simulated
from oed.export.model import Model
from oed.robot.inertia import pseudo_inertia

ROUNDING = 1e-9  # of a pseudo-inertia's largest eigenvalue, below zero
USUAL_GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2], which simulators assume


def calibrated_robot(model: Model) -> CalibratedRobot:
    """The robot with the model's bodies.

    Raises:
        NoUsableResult: If they are base parameters, or what no matter can have.
    """
    calibrated = CalibratedRobot.of(model.torque_model, model.parameters)
    bodies = calibrated.robot.parameters.reshape(-1, 10)
    for joint, body in zip(calibrated.robot.joints, bodies, strict=True):
        eigenvalues = np.linalg.eigvalsh(pseudo_inertia(body))
        if not (body[0] > 0 and eigenvalues[0] > -ROUNDING * eigenvalues[-1]):
            raise NoUsableResult(
                f"{joint.link}: no body has the inertia of this model (mass {body[0]:.3g} kg): it is "
                "one of base parameters; oed calibrate DATA, or oed feasible DATA --model FILE, leaves one of "
                "bodies"
            )
    return calibrated


def not_in_file(model: Model, form: str) -> tuple[Offline, ...]:
    """Effects that a robot file has no place for."""
    reason = f"{form} has no place for it; --to mujoco and --to drake act on it"
    effects = tuple(
        Offline(effect.name, reason)
        for effect in model.torque_model.effects[1:]
        if effect.joint_term is None and not effect.offline
    )
    return (*effects, *not_simulated(model))


def gravity_note(model: Model, form: str) -> tuple[str, ...]:
    """What to set in the simulator, where the model's gravity is not the usual one."""
    gravity = model.robot.gravity
    if np.allclose(gravity, USUAL_GRAVITY):
        return ()
    words = ", ".join(f"{x:.6g}" for x in gravity)
    return (f"{form} does not state gravity: set it to ({words}) m/s^2 in the base frame",)
