"""A model's columns on the fine grid of a prepared recording, and what its effects see there."""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.diagnosis.data.prepared import Prepared
from oed.dynamics.effects import Coulomb, Effect, State
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel

# tanh(v / width) is closest to the expected sign of a Gaussian velocity at this many sigmas.
WIDTH_PER_SIGMA = 1.25


def with_uncertain_sign(model: TorqueModel, sign_noise: Float[ndarray, " joints"]) -> TorqueModel:
    """The model whose Coulomb friction is the expectation over an uncertain velocity sign.

    Only the sign's own noise enters: a velocity shrunk like a regressor would shift it.
    """
    effects = tuple(
        dataclasses.replace(
            effect, width=max(effect.width, WIDTH_PER_SIGMA * float(sign_noise[effect.joint]))
        )
        if isinstance(effect, Coulomb)
        else effect
        for effect in model.effects
    )
    return dataclasses.replace(model, effects=effects)


def filtered_columns(
    model: TorqueModel, prepared: Prepared, columns: Int[ndarray, " kept"]
) -> Float[ndarray, "rows joints kept"]:
    """The chosen columns of a model in the analysis band."""
    fine = model.columns(prepared.motion)[:, :, columns]
    return prepared.band.apply(fine)


def effect_columns(
    effect: Effect, motion: Motion, sign_width: float
) -> dict[int, Float[ndarray, "samples columns"]]:
    """Columns of one effect on the fine grid, for the joints that it acts on."""
    state = State.along(motion, sign_width)
    entries = effect.entries(state)
    acting = sorted({joint for entry in entries for joint in entry})
    result = {}
    for joint in acting:
        rows = np.empty((len(entries), len(motion)))
        for row, entry in zip(rows, entries, strict=True):
            row[:] = entry.get(joint, 0.0)
        result[joint] = rows.T
    return result
