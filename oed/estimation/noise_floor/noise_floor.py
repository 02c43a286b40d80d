"""The noise that no model of the motion can explain, its colour and its size.

With repetitions it is what a repetition's residual lacks to those before and after it: encoder
noise carried through the regressor is in it, model error is not, nor an arm that warms up. What
comes and goes at once, such as a load, is far louder than noise while it does. Without, it is
what a rich smooth fit leaves; that is stated, and it makes every later test slower to name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped
from numpy import ndarray
from scipy.signal import fftconvolve

from oed.estimation.noise_floor.autoregression import Autoregression, fit_autoregression
from oed.experiment.preparation.prepared import Prepared

NoiseSource = Literal["repetitions", "smooth fit"]
LEAST_SHARE_OF_LAST = 0.3  # of the last repetition that must be left for it to count
BLOCK = 1.0  # [s] over which the loudness of noise is compared
QUIET = 3.0  # times the lower quartile of the blocks' deviations, beyond which it is no noise
# The same of what a fit leaves, which differs from block to block by what it lacks: a blow or a hand.
UNDISTURBED = 10.0


@dataclass(frozen=True)
class NoiseFloor:
    """Noise of each joint's torque in the analysis band.

    Attributes:
        source: Where it was read off.
        noise: Autoregression of each joint.
        deviation: (n,) standard deviation [N m].
        dilution: (n,) rows that count as one because their noise is correlated; 1 where the
            noise is whitened.
        freedom: (n,) degrees of freedom of each deviation, at least one.
    """

    source: NoiseSource
    noise: tuple[Autoregression, ...]
    deviation: Float[ndarray, " joints"]
    dilution: Float[ndarray, " joints"]
    freedom: Float[ndarray, " joints"]


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
    if length < LEAST_SHARE_OF_LAST * step:
        count, length = count - 1, step
    starts = np.round(np.arange(count) * step).astype(int)
    phases = np.arange(0, int(length) - 1, band.factor)
    return np.minimum(starts[:, None] + phases, settled - 1)


def differences(
    folded: Float[ndarray, "repetitions rows joints"],
) -> Float[ndarray, "differences rows joints"]:
    """What repetitions lack to their neighbours, with the deviation of a single one's noise.

    Second differences, to which a steady drift is nothing; of two repetitions the first.
    """
    return np.sum([share * own for share, own in _neighbours(folded)], axis=0)


def floor_from_repetitions(
    series: Sequence[Float[ndarray, "_ _ joints"]],
    trusted: Sequence[Bool[ndarray, "_ _ joints"]],
    rate: float,
    repeated: Sequence[Float[ndarray, "_ _ joints"]] | None = None,
    *,
    cutoff: float | None = None,
) -> NoiseFloor:
    """Noise floor from the differences between successive repetitions.

    Args:
        series: Residuals of the repetitions of each recording [N m].
        trusted: Which show nothing but noise.
        rate: Of the rows [Hz].
        repeated: What errs alike in all repetitions of each recording, laid out like `series`
            [N m]. No difference shows it, and it is noise of each. Beside their mean it is louder than
            beside one, and has such a share in the colour.
        cutoff: Of the rows' low-pass, which whitening does not undo [Hz]; none if None.
    """
    edge = 1.0 if cutoff is None else 2 * cutoff / rate
    apart = [x for folded in series for x in differences(folded)]
    # A difference is trusted where all that it is made of are.
    masks = [x for m in trusted for x in np.logical_and.reduce([own for _, own in _neighbours(m)])]
    masks = _quiet(apart, masks, round(BLOCK * rate))
    joints = series[0].shape[2]
    each, heard = apart, apart
    if repeated is not None:
        each = _with_repeated(series, repeated, [1.0] * len(series))
        heard = _with_repeated(series, repeated, [float(np.sqrt(len(s))) for s in series])
    noise = tuple(
        fit_autoregression([d[:, j] for d in heard], trusted=[m[:, j] for m in masks], edge=edge)
        for j in range(joints)
    )
    ones = np.ones(joints)
    deviation = _deviation(each, masks, ones)
    told = np.concatenate([_told(len(folded)) for folded in series])
    freedom = told @ np.array([m.sum(axis=0) for m in masks])
    return NoiseFloor("repetitions", noise, deviation, ones, np.maximum(freedom, 1.0))


def _with_repeated(
    series: Sequence[Float[ndarray, "_ _ joints"]],
    repeated: Sequence[Float[ndarray, "_ _ joints"]],
    shares: Sequence[float],
) -> list[Float[ndarray, "_ joints"]]:
    """Differences with what errs alike in all repetitions, by a share for each recording."""
    heard = []
    for folded, alike, share in zip(series, repeated, shares, strict=True):
        apart = differences(folded)
        heard += list(apart + share * alike[: len(apart)])
    return heard


def _neighbours(folded: Shaped[ndarray, "_ rows joints"]) -> list[tuple[float, ndarray]]:
    """The repetitions that make up each difference, and their shares in it."""
    shares = _shares(len(folded))
    count = len(folded) - len(shares) + 1
    return [(share, folded[k : k + count]) for k, share in enumerate(shares)]


def _shares(repetitions: int) -> Float[ndarray, " neighbours"]:
    """Of neighbours in a difference, which has the deviation of one."""
    shares = np.array([-1.0, 1.0] if repetitions < 3 else [1.0, -2.0, 1.0])
    return shares / np.linalg.norm(shares)


def _told(repetitions: int) -> Float[ndarray, " differences"]:
    """Degrees of freedom of each row of each difference: neighbouring ones share repetitions."""
    shares = _shares(repetitions)
    count = repetitions - len(shares) + 1
    alike = np.correlate(shares, shares, "full")[len(shares) - 1 :]
    pairs = np.where(np.arange(len(alike)) > 0, 2, 1) * np.maximum(count - np.arange(len(alike)), 0)
    return np.full(count, count / float(pairs @ alike**2))


def _quiet(
    noise: Sequence[Float[ndarray, "_ joints"]],
    trusted: Sequence[Bool[ndarray, "_ joints"]],
    block: int,
    quiet: float = QUIET,
) -> list[Bool[ndarray, "_ joints"]]:
    """Trusted rows without the blocks in which something else than noise is heard."""
    starts = [np.arange(0, len(x), block) for x in noise]
    rows = [np.add.reduceat(m, s) for m, s in zip(trusted, starts, strict=True)]
    squares = [
        np.add.reduceat(np.where(m, x**2, 0.0), s)
        for x, m, s in zip(noise, trusted, starts, strict=True)
    ]
    power = [q / np.maximum(r, 1) for q, r in zip(squares, rows, strict=True)]
    filled = np.concatenate(rows) > block / 2
    every = np.where(filled, np.concatenate(power), np.nan)
    heard = filled.any(axis=0)
    usual = np.full(every.shape[1], np.inf)  # of a joint without a trusted block nothing is known
    usual[heard] = np.nanquantile(every[:, heard], 0.25, axis=0)
    loud = [p > quiet**2 * usual for p in power]
    return [m & ~np.repeat(x, block, axis=0)[: len(m)] for m, x in zip(trusted, loud, strict=True)]


def floor_from_smooth_fit(
    residuals: Sequence[Float[ndarray, "_ joints"]],
    trusted: Sequence[Bool[ndarray, "_ joints"]],
    freedom: Float[ndarray, " joints"],
    dilution: Float[ndarray, " joints"],
    rate: float,
) -> NoiseFloor:
    """Noise floor from what a rich smooth fit leaves.

    What is left holds model error too, and whitening by its colour would fit the model to
    the frequencies where it is least wrong, not to the torque. So rows keep their colour,
    and correlated ones count less: 1 + 2 sum of the autocorrelation of them as one.

    Args:
        residuals: One array a recording [N m].
        trusted: Rows that show nothing but noise.
        freedom: (n,) share of the noise's squares that the fit left to each joint.
        dilution: (n,) rows of the noise that count as one.
        rate: Of the rows [Hz].
    """
    trusted = _quiet(residuals, trusted, round(BLOCK * rate), UNDISTURBED)
    deviation = _deviation(residuals, trusted, freedom)
    noise = tuple(Autoregression.white(d) for d in deviation)
    rows = np.sum([own.sum(axis=0) for own in trusted], axis=0)
    return NoiseFloor(
        "smooth fit", noise, deviation, dilution, np.maximum(rows * freedom / dilution, 1.0)
    )


def _deviation(
    noise: Sequence[Float[ndarray, "_ joints"]],
    trusted: Sequence[Bool[ndarray, "_ joints"]],
    freedom: Float[ndarray, " joints"],
) -> Float[ndarray, " joints"]:
    mask = np.concatenate(trusted)
    squares = np.where(mask, np.concatenate(noise) ** 2, 0.0).sum(axis=0)
    return np.sqrt(squares / np.maximum(mask.sum(axis=0), 1) / freedom)
