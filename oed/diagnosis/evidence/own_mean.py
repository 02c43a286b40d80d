"""The mean of an uneven ripple, which is no offset beside it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from oed.diagnosis.evidence.estimates import Estimated
from oed.diagnosis.evidence.verdict import FoundEffect

# Of a ripple's amplitude. A wave whose phase another of the same period moves by a, sin(x + a sin
# x), has a mean of J_1(a), at most: 0.24 for half a radian.
UNEVEN = 0.25


def with_own_means(effects: Sequence[FoundEffect]) -> tuple[FoundEffect, ...]:
    """Effects, where a small constant beside a ripple of the same joint is a part of the ripple.

    A ripple is a function of position that repeats, and such a one has a mean of its own; waves
    alone cannot say it. What is larger than an uneven ripple's mean is an offset.

    Args:
        effects: As they were found, one by one.
    """
    ripples = {e.joint: e for e in effects if e.name == "torque_ripple"}
    means = {
        e.joint: e.parameters[0]
        for e in effects
        if e.name == "torque_offset" and e.joint in ripples and _is_small(e, ripples[e.joint])
    }
    return tuple(
        _with_mean(e, means[e.joint]) if e.name == "torque_ripple" and e.joint in means else e
        for e in effects
        if not (e.name == "torque_offset" and e.joint in means)
    )


def _is_small(offset: FoundEffect, ripple: FoundEffect) -> bool:
    waves = ripple.parameters[: len(ripple.trial.effect.parameters)]
    amplitude = float(np.linalg.norm([p.value for p in waves]))
    return abs(offset.parameters[0].value) < UNEVEN * amplitude


def _with_mean(ripple: FoundEffect, mean: Estimated) -> FoundEffect:
    own = dataclasses.replace(mean, name=f"ripple_mean_{(ripple.joint or 0) + 1}")
    return dataclasses.replace(ripple, parameters=(own, *ripple.parameters))
