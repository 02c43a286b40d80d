"""What a model leaves where it is no noise: a swing at one frequency, or a moment in which something hit the arm.

Neither is a function of the motion, so no term describes it; and where noise is read off what a smooth fit
leaves, either is part of the floor. So each is looked for in what is left, by its share of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import periodogram

from oed.diagnosis.inference.errors import Predictor
from oed.diagnosis.numbers import BLOCK_SECONDS, MOSTLY, SHORTLY
from oed.experiment.preparation.prepared import Prepared

MAIN_LOBE = 2  # frequencies on each side that a steady swing spreads over under Hann's window
HANN = (
    1.5  # mean square of Hann's window over the square of its mean: by which its lobe is too large
)
LEAST_PERIODS = 10  # in a recording: slower than that, a drift or misfit of the motion looks alike


@dataclass(frozen=True)
class Disturbance:
    """What most of a joint's error is, and no motion has.

    Attributes:
        joint: From 0.
        rms: While it lasts [N m].
        share: Of the variance that is left at the joint, 0 to 1.
        words: What it is.
        exposed_by: What tells where it comes from.
    """

    joint: int
    rms: float
    share: float
    words: str
    exposed_by: str


def disturbances(
    prepared: Sequence[Prepared], weights: Sequence[Float[ndarray, "_ joints"]], model: Predictor
) -> tuple[Disturbance, ...]:
    """Swings and bursts that are most of what a model leaves of a joint; none of most joints.

    Args:
        prepared: Recordings.
        weights: Of their valid rows, from 0 to 1: less where the direction of motion is uncertain.
        model: Whose errors they are.
    """
    left, given = [], []
    for recording, weight in zip(prepared, weights, strict=True):
        own = model.torque(recording)
        error = np.zeros_like(own)
        error[recording.valid] = (recording.torque - own)[recording.valid] * np.sqrt(weight)
        left.append(error)
        given.append(own)
    found = (
        _swing_or_burst(prepared, [x[:, j] for x in left], [x[:, j] for x in given], j)
        for j in range(left[0].shape[1])
    )
    return tuple(d for d in found if d is not None)


def _swing_or_burst(
    prepared: Sequence[Prepared],
    left: Sequence[Float[ndarray, " _"]],
    given: Sequence[Float[ndarray, " _"]],
    joint: int,
) -> Disturbance | None:
    rate = prepared[0].band.analysis_rate
    swings = [swing(x, y, rate) for x, y in zip(left, given, strict=True)]
    heard = [s for s in swings if s is not None]
    if heard and len(heard) == len(swings):
        frequency, rms, share = max(heard, key=lambda s: s[1])
        return Disturbance(
            joint,
            rms,
            share,
            f"a swing at {frequency:.3g} Hz, {rms:.2g} N m rms, {share:.0%} of the variance that is left",
            "log the torque while the arm stands still, with its controller on: a swing that stays comes "
            "from the controller, the supply or the floor; one that goes is shaken loose by the motion",
        )
    sudden = burst(left, rate)
    if sudden is None:
        return None
    k, start, end, rms, share = sudden
    own = prepared[k]
    return Disturbance(
        joint,
        rms,
        share,
        f"a push from {own.t[0] + start:.1f} to {own.t[0] + end:.1f} s of {own.name}, {rms:.2g} N m rms, "
        f"{share:.0%} of the variance that is left",
        "look at what happened then, a push, a blow, a load for a moment or motion unlike all other; if it "
        "is no part of the experiment, cut it out (from and to in dataset.toml) or record the motion again",
    )


def swing(
    left: Float[ndarray, " rows"], given: Float[ndarray, " rows"], rate: float
) -> tuple[float, float, float] | None:
    """Frequency [Hz], rms and share of a line in the spectrum that has most of the variance.

    Noise of n rows has no frequency with more than about log(n) / n of it (Fisher 1929, Proc. R. Soc.
    A 125), so half of it is never chance. Where the motion itself swings so, the line may be its misfit.

    Args:
        left: Errors of a model, in time [N m].
        given: Torque that it predicts: where this has more, the motion has that frequency [N m].
        rate: Of the rows [Hz].
    """
    frequency, power = periodogram(left, rate, window="hann", scaling="spectrum")
    _, of_motion = periodogram(given, rate, window="hann", scaling="spectrum")
    power[:LEAST_PERIODS] = 0.0
    peak, variance = int(np.argmax(power)), float(np.var(left))
    near = slice(max(peak - MAIN_LOBE, 0), peak + MAIN_LOBE + 1)
    own = float(power[near].sum()) / HANN
    if variance <= 0 or own < MOSTLY * variance or power[near].sum() <= of_motion[near].sum():
        return None
    # The lobe of a swing between two frequencies has its weight between them.
    middle = float(frequency[near] @ power[near] / power[near].sum())
    return middle, float(np.sqrt(own)), min(own / variance, 1.0)


def burst(
    left: Sequence[Float[ndarray, " _"]], rate: float
) -> tuple[int, float, float, float, float] | None:
    """Recording, start and end [s], rms and share of the shortest time with most of the squares.

    Noise of any loudness that is steady has such a share in no short time.
    """
    length = max(1, round(BLOCK_SECONDS * rate))
    blocks = [np.add.reduceat(x**2, np.arange(0, len(x), length)) for x in left]
    whole, count = sum(float(b.sum()) for b in blocks), sum(len(b) for b in blocks)
    for width in range(1, int(SHORTLY * count) + 1):
        k, first, own = max(_runs(blocks, width), key=lambda run: run[2])
        if whole > 0 and own >= MOSTLY * whole:
            seconds = width * length / rate
            rms = float(np.sqrt(own / (width * length)))
            return k, first * length / rate, first * length / rate + seconds, rms, own / whole
    return None


def _runs(blocks: Sequence[Float[ndarray, " _"]], width: int) -> Iterator[tuple[int, int, float]]:
    """The loudest run of so many blocks of each recording, its first block and its squares."""
    for k, own in enumerate(blocks):
        sums = np.convolve(own, np.ones(min(width, len(own))), "valid")
        yield k, int(np.argmax(sums)), float(sums.max())
