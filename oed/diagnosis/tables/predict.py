"""Predictions of a fitted addition on recordings that it has not seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.effects import State
from oed.experiment.preparation.prepared import Prepared


def prediction_errors(
    found: Augmented,
    prepared: Sequence[Prepared],
    columns: Sequence[Float[ndarray, "_ n base"]],
) -> list[Float[ndarray, "_ joints"]]:
    """Torque less prediction in the analysis band [N m], all rows, one array a recording.

    Args:
        found: Fitted to other recordings.
        prepared: The recordings.
        columns: Their filtered base columns.
    """
    fit = found.fit
    base = fit.parameters[: len(fit.columns)]
    errors = []
    for recording, own in zip(prepared, columns, strict=True):
        error = recording.torque - own @ base
        for trial, coefficients in zip(found.chosen, found.coefficients, strict=True):
            error = error - recording.band.apply(fine_torque(trial, coefficients, recording))
        errors.append(error)
    return errors


def fine_torque(
    trial: Trial, coefficients: Float[ndarray, " columns"], recording: Prepared
) -> Float[ndarray, "samples joints"]:
    """Torque of one addition on a recording's fine grid [N m]."""
    joints = recording.torque.shape[1]
    fine = np.zeros((len(recording.motion), joints))
    state = State.along(recording.motion)
    for joint, torque in trial.effect.torque(state, coefficients).items():
        fine[:, joint] = torque
    return fine


def rms(
    errors: Sequence[Float[ndarray, "_ joints"]], weights: Sequence[Float[ndarray, "_ joints"]]
) -> Float[ndarray, " joints"]:
    """Root weighted mean square of each joint over all recordings [N m]."""
    squares = sum(np.sum((e * w) ** 2, axis=0) for e, w in zip(errors, weights, strict=True))
    return np.sqrt(squares / sum(np.sum(w**2, axis=0) for w in weights))
