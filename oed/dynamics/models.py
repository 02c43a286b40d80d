"""Torque models by name, for studies and reports."""

from __future__ import annotations

from collections.abc import Callable

from oed.dynamics.effects import RotorInertia, TorqueOffset
from oed.dynamics.torque_model import TorqueModel
from oed.robot import Robot


def build_model(name: str, robot: Robot, *, sign_width: float = 0.0) -> TorqueModel:
    """A named torque model of a robot.

    Args:
        name: A key of `MODELS`.
        robot: The machine.
        sign_width: Width of the Coulomb terms' sign, as `TorqueModel.standard` takes it [rad/s].

    Raises:
        ValueError: If there is no model of that name.
    """
    if name not in MODELS:
        raise ValueError(f"no torque model {name!r}; there are {sorted(MODELS)}")
    return MODELS[name](robot, sign_width)


def _standard(robot: Robot, sign_width: float) -> TorqueModel:
    return TorqueModel.standard(robot, sign_width=sign_width)


def _rotor(robot: Robot, sign_width: float) -> TorqueModel:
    return _standard(robot, sign_width).with_effects(*(RotorInertia(j) for j in range(robot.n)))


def _offset(robot: Robot, sign_width: float) -> TorqueModel:
    return _rotor(robot, sign_width).with_effects(*(TorqueOffset(j) for j in range(robot.n)))


MODELS: dict[str, Callable[[Robot, float], TorqueModel]] = {
    "standard": _standard,  # rigid body, Coulomb, viscous: the paper's
    "rotor": _rotor,  # the same and a rotor inertia at every joint: geared arms
    "offset": _offset,  # the same and a constant torque at every joint
}
