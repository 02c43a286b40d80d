"""A torque model one instant after another: what effects remember is handed from each to the next.

Along a recording a `TorqueModel` sees everything at once. A controller and a simulation see one
instant, and what they kept of those before. Both are the same torque; symbols go through as numbers
do, so that this is also how a model becomes code.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import Effect, State, with_columns
from oed.dynamics.effects.effect import Part, recall_effects
from oed.dynamics.effects.measurement_effect import Instants
from oed.dynamics.scalars import Scalar
from oed.dynamics.torque_model import TorqueModel

PARTS: tuple[Part, ...] = ("body", "position", "friction", "inertia")


@dataclass(frozen=True)
class Offline:
    """What of a model cannot be worked out one instant after another.

    Attributes:
        name: Of the effect.
        reason: In words.
    """

    name: str
    reason: str


def offline(model: TorqueModel) -> tuple[Offline, ...]:
    """What a model has that needs a whole recording."""
    every = (*model.effects, *model.measurement)
    return tuple(Offline(effect.name, effect.offline) for effect in every if effect.offline)


def without_offline(
    model: TorqueModel, parameters: Float[ndarray, " p"]
) -> tuple[TorqueModel, Float[ndarray, " p"]]:
    """A model and its parameters without what needs a whole recording."""
    kept = [(e, parameters[place]) for e, place in with_columns(model.effects) if not e.offline]
    rest = dataclasses.replace(
        model,
        effects=tuple(effect for effect, _ in kept),
        measurement=tuple(m for m in model.measurement if not m.offline),
    )
    return rest, np.concatenate([own for _, own in kept])


def as_recorded(model: TorqueModel, parameters: Float[ndarray, " p"], step: float) -> Instants:
    """Torque as recordings show it, one instant after another.

    Args:
        model: With nothing that is `offline`.
        parameters: Of all its columns.
        step: Between two instants [s].
    """
    found = of_the_arm(model.effects, parameters, model.robot.n, step)
    for effect in model.measurement:
        outer = effect.after(found, model.robot.n, step)
        found = Instants((*outer.keeps, *found.keeps), outer.begin, outer.recall)
    return found


def of_the_arm(
    effects: Sequence[Effect], parameters: Float[ndarray, " p"], joints: int, step: float
) -> Instants:
    """Torque that the arm itself needs, whatever its measurement does; arguments as above."""

    def begin(state: State) -> list[Scalar]:
        return [value for effect in effects for value in effect.begin(state)]

    def recall(state: State, memory: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        by_joint, kept = recall_effects(effects, parameters, state, memory, step)
        return [by_joint.get(joint, 0.0) for joint in range(joints)], kept

    return Instants(tuple(x for effect in effects for x in effect.keeps), begin, recall)


def gravity_torque(
    model: TorqueModel,
    parameters: Float[ndarray, " p"],
    state: State,
    *,
    memory: Sequence[Scalar],
    step: float,
) -> list[Scalar]:
    """Weight of all bodies, payloads among them; arguments as of `part_torque`."""
    rest = [0.0] * model.robot.n
    still = dataclasses.replace(state, dq=rest, ddq=rest)
    return part_torque("body", model, parameters, still, memory=memory, step=step)


def part_torque(
    part: Part,
    model: TorqueModel,
    parameters: Float[ndarray, " p"],
    state: State,
    *,
    memory: Sequence[Scalar],
    step: float,
) -> list[Scalar]:
    """What one part of the arm's torque is at one instant after others.

    Args:
        part: Of it.
        model: Its effects count, its measurement does not.
        parameters: Of all columns.
        state: Of that instant.
        memory: Of all effects.
        step: Between two instants [s].
    """
    own = np.concatenate(
        [
            np.where([p == part for p in effect.parts], parameters[place], 0.0)
            for effect, place in with_columns(model.effects)
        ]
    )
    by_joint, _ = recall_effects(model.effects, own, state, memory, step)
    return [by_joint.get(joint, 0.0) for joint in range(model.robot.n)]
