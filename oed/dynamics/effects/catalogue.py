"""The catalogue of effects that a diagnosis may name.

The names are part of the interface. Each entry builds a term of the same `TorqueModel`, so
that what is found can be fitted, designed for, simulated and exported like friction.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from oed.dynamics.effects.entries.friction import (
    ASYMMETRIC_VISCOUS,
    NONLINEAR_VISCOUS,
    STRIBECK,
    TORQUE_OFFSET,
)
from oed.dynamics.effects.entry import CatalogueEntry, Context, EffectPage, Shape, Target

__all__ = ["CATALOGUE", "CatalogueEntry", "Context", "EffectPage", "Shape", "Target"]

CATALOGUE: Mapping[str, CatalogueEntry] = MappingProxyType(
    {
        entry.name: entry
        for entry in (STRIBECK, NONLINEAR_VISCOUS, ASYMMETRIC_VISCOUS, TORQUE_OFFSET)
    }
)
