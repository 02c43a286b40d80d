"""Noise that moves the arm and shows in the torque: what it does to a fit.

A disturbance that the arm feels passes through the controller into the motion, and encoder noise
enters the columns. Columns and torque then err together, and least squares are biased however
long the recording (Van den Hof 1998, Annual Reviews in Control 22, 173-186; Janot, Vandanjon and
Gautier 2014, IEEE Trans. Control Systems Technology 22(1), 132-145). Repetitions show by how
much: what differs between them is nothing but such noise.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.tables.workbench import Layout, layout_of
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis_new.noise.linear_fit import Projection

MOST_NOISE = 0.5  # share of a direction's squares that is taken for noise at most
# Columns of a layout and the torque that they are to explain, all white.
Evaluate = Callable[
    [Layout], tuple[Float[ndarray, "joints rows columns"], Float[ndarray, "joints rows"]]
]


def noise_bias(
    shop: Workshop, evaluate: Evaluate, parameters: Float[ndarray, " columns"], fit: Projection
) -> Float[ndarray, " columns"]:
    """Bias of a fit to the mean repetitions; zero where no repetitions tell.

    Args:
        shop: The laid-out data.
        evaluate: Gives the columns of the fit, nuisances included, and its target.
        parameters: Estimates of all these columns' parameters.
        fit: Projection of these columns on the mean repetitions.
    """
    gram, moment = np.zeros((len(parameters),) * 2), np.zeros(len(parameters))
    mean = shop.mean.rows
    for k, recording in enumerate(mean.prepared):
        evaluated = [
            evaluate(layout_of(shop.baseline, mean.alone(k, single)))
            for single in recording.singles
        ]
        if len(evaluated) > 1:
            columns = np.stack([c for c, _ in evaluated])
            residual = np.stack([t - c @ parameters for c, t in evaluated])
            of_columns, of_residual = moments_of_mean(columns, residual)
            gram += of_columns
            moment += of_residual
    return bias_from(fit, gram, moment)


def moments_of_mean(
    columns: Float[ndarray, "repetitions joints rows columns"],
    residual: Float[ndarray, "repetitions joints rows"],
) -> tuple[Float[ndarray, "columns columns"], Float[ndarray, " columns"]]:
    """Expected products of the noise in the mean columns with itself and with the mean residual.

    Args:
        columns: Of each repetition.
        residual: Of each repetition.
    """
    count, width = len(columns), columns.shape[3]
    spread = (columns - columns.mean(axis=0)).reshape(-1, width)
    left = (residual - residual.mean(axis=0)).ravel()
    # Over M - 1 for one repetition, over M more for the mean.
    return spread.T @ spread / (count - 1) / count, spread.T @ left / (count - 1) / count


def bias_from(
    fit: Projection, gram: Float[ndarray, "columns columns"], moment: Float[ndarray, " columns"]
) -> Float[ndarray, " columns"]:
    """What these products do to the parameters: errors in variables and in the torque.

    With the true parameters t, X't = y - r and X = X_0 + E give, in the mean over the noise,
    (X'X - E'E) (found - t) = E'r at the found parameters.
    """
    share, directions = np.linalg.eigh(fit.inverse.T @ gram @ fit.inverse)
    # Nothing is said of directions that are mostly noise but that they are biased a lot.
    signal = 1 - np.clip(share, 0.0, MOST_NOISE)
    along = directions.T @ (fit.inverse.T @ moment)
    return fit.inverse @ (directions @ (along / signal))
