"""What an effect brings along, which is no other effect beside it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from oed.diagnosis.evidence.verdict import FoundEffect
from oed.dynamics.effects.catalogue import CATALOGUE

# Of a ripple's amplitude. A wave whose phase another of the same period moves by a, sin(x + a sin
# x), has a mean of J_1(a), at most: 0.24 for half a radian.
UNEVEN = 0.25


@dataclass(frozen=True)
class _Part:
    """An effect that is part of another one of its joint.

    Attributes:
        name: Of the part.
        parameter: What the other calls it, without the joint.
        belongs: Whether a part, the second argument, is what the first one brings along.
    """

    name: str
    parameter: str
    belongs: Callable[[FoundEffect, FoundEffect], bool]


def _has_mean(ripple: FoundEffect, offset: FoundEffect) -> bool:
    """A function of position that repeats has a mean of its own, which waves alone cannot say.

    What is larger than an uneven ripple's mean is an offset.
    """
    waves = ripple.parameters[: len(ripple.trial.effect.parameters)]
    amplitude = float(np.linalg.norm([p.value for p in waves]))
    return abs(offset.parameters[0].value) < UNEVEN * amplitude


def _has_rotor(_gear: FoundEffect, _rotor: FoundEffect) -> bool:
    """A gear that yields has a motor on its other side, which turns faster than a body of the joint.

    What that turns is the first of the two masses between which it yields (Spong 1987).
    """
    return True


_GEARS = (name for name, entry in CATALOGUE.items() if "compliance" in entry.families)
PARTS: Mapping[str, _Part] = {
    "torque_ripple": _Part("torque_offset", "ripple_mean", _has_mean),
    **dict.fromkeys(_GEARS, _Part("rotor_inertia", "geared_rotor", _has_rotor)),
}


def with_own_parts(effects: Sequence[FoundEffect]) -> tuple[FoundEffect, ...]:
    """Effects, each with what is part of it as a parameter instead of an effect of its own.

    Args:
        effects: As they were found, one by one.
    """
    parts = {id(whole): part for whole in effects if (part := _part_of(whole, effects)) is not None}
    taken = {id(part) for part in parts.values()}
    return tuple(
        _with_part(e, parts[id(e)]) if id(e) in parts else e for e in effects if id(e) not in taken
    )


def _part_of(whole: FoundEffect, effects: Sequence[FoundEffect]) -> FoundEffect | None:
    part = PARTS.get(whole.name)
    if part is None:
        return None
    own = (e for e in effects if (e.name, e.joint) == (part.name, whole.joint))
    return next((e for e in own if part.belongs(whole, e)), None)


def _with_part(whole: FoundEffect, part: FoundEffect) -> FoundEffect:
    name = f"{PARTS[whole.name].parameter}_{(whole.joint or 0) + 1}"
    own = dataclasses.replace(part.parameters[0], name=name)
    return dataclasses.replace(whole, parameters=(own, *whole.parameters))
