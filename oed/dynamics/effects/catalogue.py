"""The catalogue of effects that a diagnosis may name.

The names are part of the interface. Each entry builds a term of the same `TorqueModel`, so
that what is found can be fitted, designed for, simulated and exported like friction. Users add
their own with `named_effect`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Literal

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
from oed.dynamics.effects.entry import (
    Build,
    CatalogueEntry,
    Check,
    EffectPage,
    Shape,
    Target,
    by_its_shapes,
)

__all__ = [
    "CATALOGUE",
    "CatalogueEntry",
    "Context",
    "Drives",
    "EffectPage",
    "Shape",
    "Target",
    "named_effect",
    "register",
]

_ENTRIES: dict[str, CatalogueEntry] = {
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

CATALOGUE: Mapping[str, CatalogueEntry] = MappingProxyType(_ENTRIES)


def register(entry: CatalogueEntry) -> CatalogueEntry:
    """Add an effect to the catalogue, for this process.

    Args:
        entry: With a name that is not taken.

    Raises:
        ValueError: If the catalogue has another effect of that name.
    """
    if _ENTRIES.get(entry.name, entry) is not entry:
        raise ValueError(f"the catalogue has an effect {entry.name!r} already: choose another name")
    _ENTRIES[entry.name] = entry
    return entry


def named_effect(
    name: str,
    *,
    page: EffectPage,
    scope: Literal["joint", "arm", "pair"] = "joint",
    shapes: tuple[Shape, ...] = (),
    plausible: Check = by_its_shapes,
) -> Callable[[Build], CatalogueEntry]:
    """Decorate the function that builds an effect: a diagnosis may then name it.

    Args:
        name: Of the effect.
        page: What to tell about it.
        scope: Whether it belongs to a joint, to the whole arm or to a pair of joints.
        shapes: Nonlinear parameters with their plausible ranges.
        plausible: None, or why estimates cannot be right.

    Raises:
        ValueError: If the catalogue has an effect of that name.
    """

    def add(build: Build) -> CatalogueEntry:
        return register(CatalogueEntry(name, scope, shapes, build, plausible, page))

    return add
