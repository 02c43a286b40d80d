"""A model's columns on the fine grid of a prepared recording, and what its effects see there."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.dynamics.effects import Effect, State
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepared import Prepared


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
