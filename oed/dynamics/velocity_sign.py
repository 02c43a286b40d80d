"""The sign of the velocity in a model's dry friction, and the velocities over which it turns."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import Coulomb, with_columns
from oed.dynamics.torque_model import TorqueModel

# tanh(v / width) is closest to the expected sign of a Gaussian velocity at this many sigmas.
WIDTH_PER_SIGMA = 1.25


def sign_terms(model: TorqueModel) -> list[tuple[int, int, Coulomb]]:
    """Place among the effects, first column, and term of each joint's dry friction."""
    return [
        (place, at.start, effect)
        for place, (effect, at) in enumerate(with_columns(model.effects))
        if isinstance(effect, Coulomb)
    ]


def signs_of(model: TorqueModel) -> dict[int, Coulomb]:
    """The Coulomb term of each joint that has one."""
    return {effect.joint: effect for effect in _coulomb_terms(model)}


def with_signs(model: TorqueModel, signs: Mapping[int, Coulomb]) -> TorqueModel:
    """The model with these Coulomb terms in the place of those of the same joints."""
    effects = (signs.get(e.joint, e) if isinstance(e, Coulomb) else e for e in model.effects)
    return dataclasses.replace(model, effects=tuple(effects))


def widths_of(model: TorqueModel) -> list[float]:
    """Width of each Coulomb term [rad/s]."""
    return [effect.width for effect in _coulomb_terms(model)]


def with_widths(model: TorqueModel, widths: Sequence[float]) -> TorqueModel:
    """The model whose Coulomb terms turn over these velocities [rad/s], in their order."""
    pairs = zip(_coulomb_terms(model), widths, strict=True)
    turned = (dataclasses.replace(sign, width=width, gradual=False) for sign, width in pairs)
    return with_signs(model, {sign.joint: sign for sign in turned})


def _coulomb_terms(model: TorqueModel) -> list[Coulomb]:
    return [effect for _, _, effect in sign_terms(model)]


def with_uncertain_sign(model: TorqueModel, sign_noise: Float[ndarray, " joints"]) -> TorqueModel:
    """The model whose Coulomb friction is the expectation over an uncertain velocity sign.

    Only the sign's own noise enters: a velocity shrunk like a regressor would shift it.
    """
    least = WIDTH_PER_SIGMA * sign_noise
    blurred = (
        dataclasses.replace(sign, width=max(sign.width, float(least[sign.joint])))
        for sign in _coulomb_terms(model)
    )
    return with_signs(model, {sign.joint: sign for sign in blurred})
