"""What a whole search finds where there is nothing: residuals that chance might have left."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import gumbel_r

from oed.diagnosis.fit.addition import NormalEquations, normal_equations
from oed.diagnosis.fit.leverage import left_of_noise, taken_of_noise
from oed.diagnosis.fit.linear_fit import LinearFit
from oed.diagnosis.terms.scores import inflation_of, minus_log_chance, ridge_of
from oed.diagnosis.terms.trials import Trial

AT_ONCE = 64  # trials whose products with the residuals are one: thin ones wait for memory
LEAST_LEFT = 0.1  # share of noise: where a fit leaves nothing there is nothing to give back
MIDDLE = (0.08, 0.92)  # of a recording: moved by less, a residual still keeps step


def flipped(
    fit: LinearFit, count: int, rng: np.random.Generator
) -> Float[ndarray, "joints rows count"]:
    """Residuals with random signs, one a block and surrogate, common to all joints.

    Whatever keeps step with a column is destroyed, while size, bursts and colour stay.
    """
    blocks = fit.rows.blocks()
    signs = rng.choice([-1.0, 1.0], size=(int(blocks.max()) + 1, count))
    return undiminished(fit)[:, :, None] * signs[blocks][None]


def moved_in_time(
    fit: LinearFit, count: int, rng: np.random.Generator
) -> Float[ndarray, "joints rows count"]:
    """Residuals at other times of their own recording, which keep even the slowest of colours."""
    starts, result = fit.rows.starts, np.empty((*fit.residual.shape, count))
    noise = undiminished(fit)
    parts = rng.uniform(*MIDDLE, size=(len(starts) - 1, count))
    for k, (first, end) in enumerate(pairwise(starts)):
        own = noise[:, first:end]
        for s in range(count):
            result[:, first:end, s] = np.roll(own, round(parts[k, s] * own.shape[1]), axis=1)
    return result


def undiminished(fit: LinearFit) -> Float[ndarray, "joints rows"]:
    """Residuals with what noise has in common with the model, which the fit took from them.

    Beside the model, where a search looks, what is drawn from them loses as much again. A motion is
    slow: of slow noise a fit takes more than of fast. So each frequency gets back what it lost.
    """
    result, basis = np.empty_like(fit.residual), fit.projection.basis
    seen = fit.rows.weights.T > 0
    for first, end in pairwise(fit.rows.starts):
        left = left_of_noise(taken_of_noise(basis[:, first:end]), seen[:, first:end])
        spectrum = np.fft.rfft(fit.residual[:, first:end], axis=1)
        spectrum /= np.sqrt(np.maximum(left, LEAST_LEFT))
        result[:, first:end] = np.fft.irfft(spectrum, end - first, axis=1)
    return np.where(seen, result, 0.0)


def largest_surprises(
    trials: Sequence[Trial], fit: LinearFit, residuals: Float[ndarray, "joints rows count"]
) -> Float[ndarray, " count"]:
    """Largest surprise of a whole search in each of several residuals.

    The maximum over all trials carries the multiplicity of the search.
    """
    inside = np.einsum("jrb,jrs->bs", fit.projection.basis, residuals, optimize=True)
    largest = np.zeros(residuals.shape[2])
    inflation = inflation_of(fit)
    for start in range(0, len(trials), AT_ONCE):
        some = trials[start : start + AT_ONCE]
        for trial, along in zip(some, _moments(some, residuals), strict=True):
            normal = normal_equations(fit.projection, fit.residual, trial.group)
            moments = along - normal.inside.T @ inside
            share = float(inflation[list(trial.group)].mean())
            largest = np.maximum(largest, _surprises(trial, normal, moments, share))
    return largest


def _moments(
    trials: Sequence[Trial], residuals: Float[ndarray, "joints rows count"]
) -> list[Float[ndarray, "_ count"]]:
    """Moments of each trial's columns with many residuals: one product for all of a joint."""
    result: list[Float[ndarray, "_ count"]] = [np.zeros(())] * len(trials)
    for joint, residual in enumerate(residuals):
        own = [k for k, trial in enumerate(trials) if joint in trial.group]
        if not own:
            continue
        blocks = [trials[k].group[joint] for k in own]
        ends = np.cumsum([block.shape[1] for block in blocks])
        products = np.split(np.concatenate(blocks, axis=1).T @ residual, ends[:-1])
        for k, product in zip(own, products, strict=True):
            result[k] = result[k] + product
    return result


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
