"""What a whole search finds where there is nothing: residuals that chance might have left."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import gumbel_r

from oed.diagnosis.fit.addition import NormalEquations, normal_equations
from oed.diagnosis.fit.linear_fit import LinearFit
from oed.diagnosis.search.scan import inflation_of, minus_log_chance, ridge_of
from oed.diagnosis.terms.trials import Trial

MIDDLE = (0.08, 0.92)  # of a recording: moved by less, a residual still keeps step


def flipped(
    fit: LinearFit, count: int, rng: np.random.Generator
) -> Float[ndarray, "joints rows count"]:
    """Residuals with random signs, one a block and surrogate, common to all joints.

    Whatever keeps step with a column is destroyed, while size, bursts and colour stay.
    """
    blocks = fit.rows.blocks()
    signs = rng.choice([-1.0, 1.0], size=(int(blocks.max()) + 1, count))
    return fit.residual[:, :, None] * signs[blocks][None]


def moved_in_time(
    fit: LinearFit, count: int, rng: np.random.Generator
) -> Float[ndarray, "joints rows count"]:
    """Residuals at other times of their own recording, which keep even the slowest of colours."""
    starts, result = fit.rows.starts, np.empty((*fit.residual.shape, count))
    parts = rng.uniform(*MIDDLE, size=(len(starts) - 1, count))
    for k, (first, end) in enumerate(pairwise(starts)):
        own = fit.residual[:, first:end]
        for s in range(count):
            result[:, first:end, s] = np.roll(own, round(parts[k, s] * own.shape[1]), axis=1)
    return result


def largest_surprises(
    trials: Sequence[Trial], fit: LinearFit, residuals: Float[ndarray, "joints rows count"]
) -> Float[ndarray, " count"]:
    """Largest surprise of a whole search in each of several residuals.

    The maximum over all trials carries the multiplicity of the search.
    """
    count = residuals.shape[2]
    inside = np.einsum("jrb,jrs->bs", fit.projection.basis, residuals, optimize=True)
    largest = np.zeros(count)
    inflation = inflation_of(fit)
    for trial in trials:
        normal = normal_equations(fit.projection, fit.residual, trial.group)
        moments = np.zeros((len(normal.lengths), count))
        for joint, block in trial.group.items():
            moments += block.T @ residuals[joint]
            moments -= (fit.projection.basis[joint].T @ block).T @ inside
        share = float(inflation[list(trial.group)].mean())
        largest = np.maximum(largest, _surprises(trial, normal, moments, share))
    return largest


def family_p_value(surprise: float, surrogates: Float[ndarray, " count"]) -> float:
    """Chance that a search through noise surprises as much, from a Gumbel tail."""
    scale = max(float(np.std(surrogates)) * np.sqrt(6) / np.pi, 0.5)
    location = float(np.mean(surrogates)) - np.euler_gamma * scale
    return float(np.clip(gumbel_r.sf(surprise, location, scale), 1e-300, 1.0))


def _surprises(
    trial: Trial,
    normal: NormalEquations,
    moments: Float[ndarray, "columns count"],
    inflation: float,
) -> Float[ndarray, " count"]:
    """Surprise of one trial by the moments of its columns with each of many residuals."""
    directions = normal.directions()
    if not directions.rank:
        return np.zeros(moments.shape[1])
    if trial.fixed:
        gains = np.maximum(2 * moments.sum(axis=0) - normal.gram.sum(), 0.0)
    else:
        gains = directions.gains(moments, ridge_of(trial))
    freedom = (0 if trial.fixed else directions.rank) + trial.shapes
    return minus_log_chance(gains / inflation, max(freedom, 1))
