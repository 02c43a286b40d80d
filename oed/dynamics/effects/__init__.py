"""Torque effects: one family a file, one shape for all.

An effect is a few columns of the torque regressor, given its nonlinear parameters.
"""

from oed.dynamics.effects.effect import (
    Effect,
    Parameter,
    State,
    with_columns,
)
from oed.dynamics.effects.friction import Coulomb, Viscous
from oed.dynamics.effects.measurement_effect import MeasurementEffect
from oed.dynamics.effects.motor import MotorCoupling, RotorInertia
from oed.dynamics.effects.offset import TorqueOffset
from oed.dynamics.effects.rigid_body import RigidBody

__all__ = [
    "Coulomb",
    "Effect",
    "MeasurementEffect",
    "MotorCoupling",
    "Parameter",
    "RigidBody",
    "RotorInertia",
    "State",
    "TorqueOffset",
    "Viscous",
    "with_columns",
]
