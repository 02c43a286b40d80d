"""What an effect brings along, which is no other effect beside it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from oed.diagnosis.evidence.verdict import FoundEffect

# Of a ripple's amplitude. A wave whose phase another of the same period moves by a, sin(x + a sin
# x), has a mean of J_1(a), at most: 0.24 for half a radian.
UNEVEN = 0.25


# Of each effect, what may be part of it, and what it is called there. A gear that yields has a motor
# on its other side, which turns faster than a body of the joint: the first of the two masses between
# which it yields (Spong 1987).
PARTS: Mapping[str, tuple[str, str]] = {
    "torque_ripple": ("torque_offset", "ripple_mean"),
    "joint_elasticity": ("rotor_inertia", "geared_rotor"),
    "backlash": ("rotor_inertia", "geared_rotor"),
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
    if whole.name not in PARTS:
        return None
    name, _ = PARTS[whole.name]
    own = (e for e in effects if (e.name, e.joint) == (name, whole.joint))
    return next((e for e in own if name != "torque_offset" or _is_mean(e, whole)), None)


def _is_mean(offset: FoundEffect, ripple: FoundEffect) -> bool:
    """Whether a constant is no larger than the mean of an uneven ripple.

    A function of position that repeats has a mean of its own, which waves alone cannot say.
    """
    waves = ripple.parameters[: len(ripple.trial.effect.parameters)]
    amplitude = float(np.linalg.norm([p.value for p in waves]))
    return abs(offset.parameters[0].value) < UNEVEN * amplitude


def _with_part(whole: FoundEffect, part: FoundEffect) -> FoundEffect:
    _, name = PARTS[whole.name]
    own = dataclasses.replace(part.parameters[0], name=f"{name}_{(whole.joint or 0) + 1}")
    return dataclasses.replace(whole, parameters=(own, *whole.parameters))
