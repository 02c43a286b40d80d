"""What a whole search finds where there is nothing: residuals that chance might have left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import gumbel_r

from oed.diagnosis.terms.scores import inflation_of, minus_log_chance, ridge_of
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.noise.addition import (
    NormalEquations,
    moments_of_all,
    normal_equations_of_all,
)
from oed.diagnosis_new.noise.leverage import left_of_noise, taken_of_noise
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.diagnosis_new.rows.weighted_rows import Rows

LEAST_LEFT = 0.1  # share of noise: where a fit leaves nothing there is nothing to give back
SMALLEST = 1e-12  # chance that a tail fitted to some draws can tell
MIDDLE = (0.08, 0.92)  # of a recording: moved by less, a residual still keeps step


def flipped(
    noise: Float[ndarray, "joints rows"], rows: Rows, count: int, rng: np.random.Generator
) -> Float[ndarray, "joints rows count"]:
    """Noise with random signs, one a block and surrogate, common to all joints.

    Whatever keeps step with a column is destroyed, while size, bursts and colour stay.
    """
    blocks = rows.blocks()
    signs = rng.choice([-1.0, 1.0], size=(int(blocks.max()) + 1, count))
    return noise[:, :, None] * signs[blocks][None]


def moved_in_time(
    noise: Float[ndarray, "joints rows"], rows: Rows, count: int, rng: np.random.Generator
) -> Float[ndarray, "joints rows count"]:
    """Noise at other times of its own recording, which keeps even the slowest of colours."""
    starts, result = rows.starts, np.empty((*noise.shape, count))
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


@dataclass(frozen=True)
class NullSearch:
    """Trials beside a model, ready to be held against what chance might have left.

    Attributes:
        fit: The model's.
        trials: All that a search tries.
        equations: Of each beside the model.
    """

    fit: LinearFit
    trials: Sequence[Trial]
    equations: Sequence[tuple[list[int], NormalEquations]]

    @classmethod
    def beside(cls, fit: LinearFit, trials: Sequence[Trial]) -> NullSearch:
        """Lay trials out beside a model."""
        groups, grams = [t.group for t in trials], [t.gram for t in trials]
        found = normal_equations_of_all(fit.projection, fit.residual, groups, grams)
        return cls(fit, trials, found)

    def largest_surprises(
        self, residuals: Float[ndarray, "joints rows count"]
    ) -> Float[ndarray, " count"]:
        """Largest surprise of the whole search in each of several residuals.

        The maximum over all trials carries the multiplicity of the search.
        """
        inside = np.einsum("jrb,jrs->bs", self.fit.projection.basis, residuals, optimize=True)
        inflation = inflation_of(self.fit)
        most: dict[int, Float[ndarray, " count"]] = {}
        moments = moments_of_all([t.group for t in self.trials], residuals)
        for places, equations in self.equations:
            own = [self.trials[k] for k in places]
            outside = np.stack([moments[k] for k in places]) - (
                equations.inside.swapaxes(-1, -2) @ inside
            )
            noise = np.array([inflation[list(t.group)].mean() for t in own])
            gains = _gains(own, equations, outside) / noise[:, None]
            for trial, rank, gain in zip(own, equations.directions.rank, gains, strict=True):
                freedom = max(trial.shapes + (0 if trial.fixed else int(rank)), 1)
                most[freedom] = np.maximum(most.get(freedom, 0.0), gain)
        # Of as many parameters, what gains most surprises most.
        largest = [minus_log_chance(gains, freedom) for freedom, gains in most.items()]
        return np.max([np.zeros(residuals.shape[2]), *largest], axis=0)


def _gains(
    trials: Sequence[Trial],
    equations: NormalEquations,
    moments: Float[ndarray, "trials columns count"],
) -> Float[ndarray, "trials count"]:
    """What each trial gains by its moments with each of many residuals."""
    directions = equations.directions
    gains = directions.gains(moments, np.array([ridge_of(t) for t in trials]))
    fixed = [k for k, trial in enumerate(trials) if trial.fixed and directions.rank[k]]
    sizes = equations.gram[fixed].sum(axis=(1, 2))
    gains[fixed] = np.maximum(2 * moments[fixed].sum(axis=1) - sizes[:, None], 0.0)
    return gains


def family_p_value(surprise: float, surrogates: Float[ndarray, " count"]) -> float:
    """Chance that a search through noise surprises as much, from a Gumbel tail."""
    scale = max(float(np.std(surrogates)) * np.sqrt(6) / np.pi, 0.5)
    location = float(np.mean(surrogates)) - np.euler_gamma * scale
    return float(np.clip(gumbel_r.sf(surprise, location, scale), SMALLEST, 1.0))
