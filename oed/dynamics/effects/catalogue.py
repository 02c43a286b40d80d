"""The catalogue of effects that a diagnosis may name.

The names are part of the interface. Each entry builds a term of the same `TorqueModel`, so
that what is found can be fitted, designed for, simulated and exported like friction.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from oed.dynamics.effects.context import Context, Drives
from oed.dynamics.effects.entries import (
    friction,
    history,
    load,
    measurement,
    motor,
    payload,
    position,
    transmission,
)
from oed.dynamics.effects.entry import CatalogueEntry, EffectPage, Shape, Target

__all__ = ["CATALOGUE", "CatalogueEntry", "Context", "Drives", "EffectPage", "Shape", "Target"]

CATALOGUE: Mapping[str, CatalogueEntry] = MappingProxyType(
    {
        entry.name: entry
        for entry in (
            friction.STRIBECK,
            friction.NONLINEAR_VISCOUS,
            friction.ASYMMETRIC_VISCOUS,
            friction.TORQUE_OFFSET,
            history.PRESLIDING_HYSTERESIS,
            transmission.BACKLASH,
            load.LOAD_DEPENDENT_FRICTION,
            position.POSITION_DEPENDENT_FRICTION,
            position.TORQUE_RIPPLE,
            position.JOINT_SPRING,
            measurement.GRAVITY_DIRECTION,
            motor.ROTOR_INERTIA,
            motor.MOTOR_COUPLING,
            load.TORQUE_GAIN,
            load.TORQUE_SATURATION,
            measurement.TIME_DELAY,
            measurement.FILTER_LAG,
            transmission.JOINT_ELASTICITY,
            history.THERMAL_DRIFT,
            payload.PAYLOAD_CHANGE,
            measurement.ENCODER_ECCENTRICITY,
        )
    }
)
