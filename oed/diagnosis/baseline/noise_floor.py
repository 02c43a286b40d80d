"""The noise that no model of the motion can explain, its colour and its size.

With repetitions it is the difference between one repetition's residual and the next: encoder
noise carried through the regressor is in it, model error is not. Without, it is what a rich
free-form fit leaves; that is stated, and it makes every later test slower to name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray
from scipy.signal import fftconvolve

from oed.diagnosis.data.prepare import Prepared
from oed.diagnosis.fit.whitening import Autoregression, fit_autoregression

NoiseSource = Literal["repetitions", "free-form fit"]
LEAST_SHARE_OF_PERIOD = 0.3  # of the last repetition that must be left for it to count


@dataclass(frozen=True)
class NoiseFloor:
    """Noise of each joint's torque in the analysis band.

    Attributes:
        source: Where it was read off.
        noise: Autoregression of each joint.
        deviation: (n,) standard deviation [N m].
        dilution: (n,) rows that count as one because their noise is correlated; 1 where the
            noise is whitened.
    """

    source: NoiseSource
    noise: tuple[Autoregression, ...]
    deviation: Float[ndarray, " joints"]
    dilution: Float[ndarray, " joints"]


def repetition_series(
    recording: Prepared, fine_residual: Float[ndarray, "samples joints"]
) -> Float[ndarray, "repetitions rows joints"]:
    """Filtered residual of each repetition, all at the same phases.

    Args:
        recording: With at least two repetitions.
        fine_residual: Unfiltered residual on its fine grid [N m].

    Raises:
        ValueError: If the recording has no repetitions.
    """
    filtered = fftconvolve(fine_residual, recording.band.taps[:, None], mode="valid", axes=0)
    return filtered[repetition_samples(recording)]


def repetition_samples(recording: Prepared) -> Int[ndarray, "repetitions rows"]:
    """Where the rows of each repetition lie among the settled fine samples.

    Raises:
        ValueError: If the recording has no repetitions.
    """
    if recording.period is None:
        raise ValueError(f"{recording.name} has no repetitions")
    band = recording.band
    settled = len(recording.motion) - 2 * band.reach
    step = recording.period * band.rate
    count = len(np.unique(recording.repetition))
    length = min(step, settled - (count - 1) * step)
    if length < LEAST_SHARE_OF_PERIOD * step:
        count, length = count - 1, step
    starts = np.round(np.arange(count) * step).astype(int)
    phases = np.arange(0, int(length) - 1, band.factor)
    return np.minimum(starts[:, None] + phases, settled - 1)


def floor_from_repetitions(
    series: Sequence[Float[ndarray, "_ _ joints"]],
    trusted: Sequence[Bool[ndarray, "_ _ joints"]],
) -> NoiseFloor:
    """Noise floor from the differences between successive repetitions.

    Differences of neighbours hardly see a drift that is slow against the period.
    """
    differences, masks = [], []
    for folded, mask in zip(series, trusted, strict=True):
        differences += list((folded[1:] - folded[:-1]) / np.sqrt(2))
        masks += list(mask[1:] & mask[:-1])
    joints = series[0].shape[2]
    noise = tuple(
        fit_autoregression([d[:, j] for d in differences], trusted=[m[:, j] for m in masks])
        for j in range(joints)
    )
    deviation = _deviation(differences, masks, np.ones(joints))
    return NoiseFloor("repetitions", noise, deviation, np.ones(joints))


def floor_from_free_form(
    residuals: Sequence[Float[ndarray, "_ joints"]],
    trusted: Sequence[Bool[ndarray, "_ joints"]],
    freedom: Float[ndarray, " joints"],
) -> NoiseFloor:
    """Noise floor from what a rich free-form fit leaves.

    What is left holds model error too, and whitening by its colour would fit the model to
    the frequencies where it is least wrong, not to the torque. So rows keep their colour,
    and correlated ones count less: 1 + 2 sum of the autocorrelation of them as one.

    Args:
        residuals: One array a recording [N m].
        trusted: Rows that show nothing but noise.
        freedom: (n,) share of the degrees of freedom that the fit left to each joint.
    """
    deviation = _deviation(residuals, trusted, freedom)
    noise = tuple(Autoregression(np.ones(1), max(float(d), 1e-9)) for d in deviation)
    dilution = np.array(
        [correlated_rows([r[:, j] for r in residuals]) for j in range(len(deviation))]
    )
    return NoiseFloor("free-form fit", noise, deviation, dilution)


def correlated_rows(series: Sequence[Float[ndarray, " _"]]) -> float:
    """1 + 2 sum of the autocorrelation up to its first zero."""
    power = sum(float(x @ x) for x in series)
    total = 1.0
    for lag in range(1, min(len(x) for x in series) // 4):
        correlation = sum(float(x[lag:] @ x[:-lag]) for x in series) / max(power, 1e-300)
        if correlation <= 0:
            break
        total += 2 * correlation
    return total


def _deviation(
    noise: Sequence[Float[ndarray, "_ joints"]],
    trusted: Sequence[Bool[ndarray, "_ joints"]],
    freedom: Float[ndarray, " joints"],
) -> Float[ndarray, " joints"]:
    mask = np.concatenate(trusted)
    squares = np.where(mask, np.concatenate(noise) ** 2, 0.0).sum(axis=0)
    return np.sqrt(squares / np.maximum(mask.sum(axis=0), 1) / freedom)
