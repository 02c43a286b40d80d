"""The mean over repetitions: as much about the motion's effects as all of them, in fewer rows."""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.experiment.preparation.encoder_steps import rounding_deviation
from oed.experiment.preparation.prepared import Prepared

# Repetitions whose positions differ by more than this share of the motion are not repetitions:
# their mean would be a motion that nobody ran.
LARGEST_SPREAD = 0.01
LEAST_SHARE_OF_PERIOD = 0.6  # of the period that all repetitions must have in common


def mean_of_repetitions(prepared: Prepared) -> tuple[Prepared, int]:
    """The recording's mean repetition, and how many it is the mean of.

    The samples between the cut edges that all repetitions share are averaged. A recording
    without repetitions, or whose repetitions disagree, is returned as it is, with 1.
    """
    index = _common_samples(prepared)
    if index is None:
        return prepared, 1
    return _averaged(prepared, index), len(index)


def _common_samples(prepared: Prepared) -> Int[ndarray, "repetitions samples"] | None:
    """Fine samples of each repetition at phases that all share; None where they disagree."""
    if prepared.period is None:
        return None
    motion, rate = prepared.motion, prepared.band.rate
    step = prepared.period * rate
    count = len(np.unique(prepared.repetition))
    length = int(min(step, len(motion) - (count - 1) * step))
    if count < 2 or length < LEAST_SHARE_OF_PERIOD * step:
        return None
    starts = np.round(np.arange(count) * step).astype(int)
    index = np.minimum(starts[:, None] + np.arange(length), len(motion) - 1)
    spread = np.std(motion.q[index], axis=0).max(axis=0)
    if np.any(spread > LARGEST_SPREAD * np.ptp(motion.q, axis=0)):
        return None
    return index


def _averaged(prepared: Prepared, index: Int[ndarray, "repetitions samples"]) -> Prepared:
    """One repetition that is the mean of those given."""
    motion, count = prepared.motion, len(index)
    q, dq, ddq, torque = (
        _mean(x, index) for x in (motion.q, motion.dq, motion.ddq, prepared.fine_torque)
    )
    noise = None if motion.noise is None else tuple(x / count for x in motion.noise)
    motion = dataclasses.replace(motion, noise=noise)
    warmth = motion.temperature
    mean = dataclasses.replace(
        motion,
        t=motion.t[: index.shape[1]],
        q=q,
        dq=dq,
        ddq=ddq,
        temperature=None if warmth is None else _mean(warmth, index),
    )
    q, dq, ddq = (np.tile(x, (count, 1)) for x in (q, dq, ddq))
    laps = dataclasses.replace(motion[index.ravel()], q=q, dq=dq, ddq=ddq)
    t = prepared.band.instants(mean.t)
    return dataclasses.replace(
        prepared,
        motion=mean,
        fine_torque=torque,
        torque=prepared.band.apply(torque),
        t=t,
        repetition=np.full(len(t), -1),
        period=None,
        position_noise=_position_noise(prepared, count),
        sign_noise=prepared.sign_noise / np.sqrt(count),
        recorded=prepared.recorded[index].all(axis=0),
        laps=laps,
    )


def _position_noise(prepared: Prepared, count: int) -> Float[ndarray, " joints"]:
    """(n,) of the mean over so many repetitions [rad]: what comes again in each stays."""
    repeated = rounding_deviation(prepared.repeated_steps) ** 2
    rest = np.maximum(prepared.position_noise**2 - repeated, 0.0)
    return np.sqrt(repeated + rest / count)


def _mean(x: Float[ndarray, "samples joints"], index: ndarray) -> Float[ndarray, "_ joints"]:
    total = np.zeros((index.shape[1], x.shape[1]))
    for row in index:
        total += x[row]
    return total / len(index)
