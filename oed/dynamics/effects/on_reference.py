"""Effects of the torque as modelled: what holds a reference torque, and where references end."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import TypeVar

from oed.dynamics.effects.effect import Columns, Effect, State, with_columns
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.scalars import Scalar

PartT = TypeVar("PartT")


class FollowsTorque(Effect):
    """An effect of the torque as modelled: it keeps what that does."""

    reference: ReferenceTorque

    def changes_along(self, coordinate: str) -> bool:  # noqa: ARG002  # the torque does with any
        """As the torque does, whatever it depends on itself."""
        return True

    @property
    def keeps(self) -> tuple[str, ...]:
        """As the torque's other effects."""
        return self.reference.keeps

    def begin(self, state: State) -> Sequence[Scalar]:
        """As the torque's other effects."""
        return self.reference.begin(state)

    def recall(
        self, state: State, memory: Sequence[Scalar], step: float
    ) -> tuple[Columns, Sequence[Scalar]]:
        """Its columns for the torque of that instant."""
        now, following = self.reference.recall(state, memory, step)
        own = dataclasses.replace(self, reference=now)  # pyright: ignore[reportArgumentType]
        return own.entries(state), following


def holds_reference(value: object) -> bool:
    """Whether an effect, or a part of it, changes with the torque as modelled so far."""
    if isinstance(value, ReferenceTorque):
        return True
    return any(holds_reference(getattr(value, name)) for name in _parts(value))


def with_references(value: PartT, change: Callable[[ReferenceTorque], ReferenceTorque]) -> PartT:
    """An effect with each reference torque that it or a part of it holds put through `change`."""
    if isinstance(value, ReferenceTorque):
        return change(value)  # pyright: ignore[reportReturnType]
    own = {name: getattr(value, name) for name in _parts(value)}
    new = {name: with_references(part, change) for name, part in own.items() if part is not None}
    new = {name: part for name, part in new.items() if part is not own[name]}
    return dataclasses.replace(value, **new) if new else value  # pyright: ignore[reportArgumentType, reportReturnType]


def with_ends(effects: Sequence[Effect]) -> list[Effect]:
    """Effects whose reference torques hold none that follow a torque themselves.

    A model that is fitted again and again refers to the last fit: a reference to a reference would
    have no end.
    """
    ends: dict[int, ReferenceTorque] = {}

    def end(reference: ReferenceTorque) -> ReferenceTorque:
        if id(reference) not in ends:
            ends[id(reference)] = _without_followers(reference)
        return ends[id(reference)]

    return [with_references(effect.leaving, end) for effect in effects]


def _without_followers(reference: ReferenceTorque) -> ReferenceTorque:
    pairs = [
        (effect, reference.coefficients[place])
        for effect, place in with_columns(reference.others)
        if not holds_reference(effect)
    ]
    if len(pairs) == len(reference.others):
        return reference
    sizes = tuple(size for _, own in pairs for size in own)
    return ReferenceTorque(reference.robot, tuple(effect for effect, _ in pairs), sizes)


def _parts(value: object) -> tuple[str, ...]:
    """Fields of a dataclass; of anything else none."""
    if isinstance(value, type) or not dataclasses.is_dataclass(value):
        return ()
    return tuple(f.name for f in dataclasses.fields(value) if f.init)
