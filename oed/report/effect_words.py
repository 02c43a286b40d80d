"""What a report says of a named effect: its place, and how well its parameters are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oed.diagnosis.evidence.estimates import UNSEEN_TILT, Estimated
from oed.diagnosis.evidence.verdict import FoundEffect
from oed.dynamics.effects.catalogue import CATALOGUE, Context, Shape
from oed.dynamics.effects.effect import Effect
from oed.dynamics.effects.entries.payload import visible_load
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.effects.thermal import WarmFriction
from oed.robot.robot import Joint

WHOLE_RANGE = 0.999  # of the spread of a uniform distribution: the data say no more than the range
ROUNDING = 1e-9  # of a shape's range: what moves nothing is no estimate
AT_BOUND = 1e-3  # of the range
CHOSEN = "chosen, not estimated"


@dataclass(frozen=True)
class KnownParameter:
    """A parameter of an effect as it may be told.

    Attributes:
        name: Symbol in words.
        value: In `unit`.
        std: Standard deviation; of a shape no more than that of its plausible range.
        unit: At this joint.
        note: In words why `std` is no measurement; None where it is one.
        stands_for: Sum that the data show it as a part of; None where it is itself.
    """

    name: str
    value: float
    std: float
    unit: str
    note: str | None = None
    stands_for: str | None = None

    @property
    def label(self) -> str:
        """The name, with what it stands for if that is more."""
        return self.name if self.stands_for is None else f"{self.name} ({self.stands_for})"

    @property
    def uncertainty(self) -> float | str:
        """The standard deviation, or why there is none."""
        return self.std if self.note is None else self.note


def place_of(name: str, joint: int | None, labels: Sequence[str]) -> str:
    """Such as "stribeck on joint 2"; an effect of the whole arm by its name alone."""
    return name if joint is None else f"{name} on {labels[joint]}"


def known_parameters(
    effect: FoundEffect, context: Context, joints: Sequence[Joint]
) -> list[KnownParameter]:
    """Coefficients and shapes of an effect, with their units at its joint.

    Args:
        effect: Found.
        context: In which it was tried: it narrows the shapes' ranges.
        joints: Of the robot.
    """
    trial = effect.trial
    shapes = CATALOGUE[effect.name].shapes_for(context, trial.target)
    coefficients = len(effect.parameters) - len(trial.values)
    notes = [_size_note(p) for p in effect.parameters[:coefficients]] + [
        _shape_note(p.value, p.std, shape)
        for p, shape in zip(effect.parameters[coefficients:], shapes, strict=True)
    ]
    sums = _sums(trial.effect, coefficients) + [None] * len(trial.values)
    known = [
        KnownParameter(p.name, p.value, p.std, _unit(p.unit, effect.joint, joints), note, whole)
        for p, note, whole in zip(effect.parameters, notes, sums, strict=True)
    ]
    if isinstance(trial.effect, WarmFriction):  # has neither time constant nor clock
        at = KnownParameter("reference", trial.effect.reference, 0.0, "°C", CHOSEN)
        known = [*known[:coefficients], at]
    return known


def _size_note(size: Estimated) -> str | None:
    """Why a tilt has no deviation that was measured; None for all other sizes."""
    is_open = size.unit == "rad" and size.std >= WHOLE_RANGE * UNSEEN_TILT
    return "unknown: no joint feels it" if is_open else None


def _sums(effect: Effect, coefficients: int) -> list[str | None]:
    """What a load's parameters stand for, where that is more than their names say."""
    if not isinstance(effect, PayloadChange):
        return [None] * coefficients
    names = effect.robot.parameter_names[10 * effect.link :]
    seen = visible_load(effect.robot, effect.link)
    return [
        None if words == names[k] else words
        for k, words in zip(seen.kept, seen.expressions, strict=True)
    ]


def _shape_note(value: float, std: float, shape: Shape) -> str | None:
    width = shape.upper - shape.lower
    if shape.is_idle(value):
        return "for good"
    if not shape.is_estimated or width <= 0 or std <= ROUNDING * width:
        return CHOSEN
    if std < WHOLE_RANGE * width / np.sqrt(12):
        place = shape.place_of(value)
        if min(place, 1 - place) >= AT_BOUND:
            return None
        return "at its least" if place < AT_BOUND else "at its largest"
    if min(value - shape.lower, shape.upper - value) < AT_BOUND * width:
        return "at its bound, unknown"
    return f"unknown between {shape.lower:.3g} and {shape.upper:.3g}"


def _unit(unit: str, joint: int | None, joints: Sequence[Joint]) -> str:
    return unit if joint is None else joints[joint].unit(unit)
