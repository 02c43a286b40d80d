"""The signals of a log on a uniform grid, and where that grid lies between logged rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.experiment.preparation.band import EDGE
from oed.experiment.preparation.bridge import bridged
from oed.experiment.preparation.fresh import fresh_samples
from oed.experiment.recording import Recording
from oed.experiment.signals.gaps import find_gaps
from oed.experiment.signals.lowpass import lowpass
from oed.experiment.signals.resampling import resample, uniform_grid

FINEST_RATE = 1000.0  # [Hz] of the uniform grid; arms and encoders give nothing beyond
# Samples times joints of a log that is mainly pauses: 0.4 GB for each of several signals.
MOST_ON_GRID = 50_000_000
LEAST_STRETCH = 1.0  # [s] between gaps for a spectrum of the position
ALIASING = 0.4  # of a coarser grid's rate, to which signals are low-passed before they are thinned


@dataclass(frozen=True)
class Uniform:
    """A log at one rate.

    Attributes:
        t: (N,) [s].
        q: (N, n) [rad or m].
        tau: (N, n) [N m or N].
        dq: (N, n) as it was logged; None where it was not.
    """

    t: Float[ndarray, " samples"]
    q: Float[ndarray, "samples joints"]
    tau: Float[ndarray, "samples joints"]
    dq: Float[ndarray, "samples joints"] | None


def uniform_rate(recordings: Sequence[Recording]) -> float:
    """Common rate [Hz]: the slowest recording's, rounded, at most 1 kHz."""
    slowest = min(1 / float(np.median(np.diff(r.t))) for r in recordings)
    return min(FINEST_RATE, float(f"{slowest:.3g}"))


def uniform(recording: Recording, rate: float) -> Uniform:
    """A recording on a uniform grid, rows that only repeat the one before left out."""
    fresh = fresh_samples(recording)
    logged = 1 / float(np.median(np.diff(recording.t)))
    t = recording.t[fresh]
    # Whole steps by averaging first: interpolation alone would fold high noise into the band.
    step = max(1, round(logged / rate))
    _check_length(recording, rate * step)
    dense = uniform_grid(t, rate * step)

    def thinned(x: Float[ndarray, "dense joints"]) -> Float[ndarray, "samples joints"]:
        return lowpass(x, rate * step, ALIASING * rate)[::step] if step > 1 else x

    q = thinned(bridged(t, recording.q[fresh], dense, rate))
    tau, dq = (
        None if x is None else thinned(resample(t, x[fresh], dense))
        for x in (recording.tau, recording.dq)
    )
    if tau is None:
        raise ValueError(f"{recording.name}: no torque was logged")
    return Uniform(dense[::step], q, tau, dq)


def _check_length(recording: Recording, rate: float) -> None:
    """Refuse pauses that would fill the memory: a grid has samples in them as well."""
    samples = recording.duration * rate
    if samples > 2 * len(recording) and samples * recording.q.shape[1] > MOST_ON_GRID:
        raise ValueError(
            f"{recording.name}: with its pauses it lasts {recording.duration:.3g} s, which are "
            f"{samples:.2g} samples at {rate:g} Hz, of {len(recording)} that were logged: cut it where it "
            "pauses, into a [[recording]] each with rows, or from and to"
        )


def recorded(
    recording: Recording, t: Float[ndarray, " samples"], rate: float, edge: float = EDGE
) -> Bool[ndarray, " samples"]:
    """False in gaps of the log, such as between runs, and where smoothing feels them."""
    inside = np.ones(len(t), dtype=bool)
    for k in find_gaps(recording.t, rate):
        before, after = recording.t[k], recording.t[k + 1]
        inside &= (t < before - edge) | (t > after + edge)
    return inside


def between_gaps(recording: Recording, t: Float[ndarray, " samples"], rate: float) -> list[slice]:
    """Where a log on a uniform grid has no gap: the leap across one would pass for fast motion."""
    inside = recorded(recording, t, rate)
    edges = np.flatnonzero(np.diff(inside, prepend=False, append=False)).tolist()
    stretches = [slice(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    longest = max((s.stop - s.start for s in stretches), default=0)
    # Short stretches tell little of slow motion, and would shorten the spectra of all.
    least = max(longest / 2, LEAST_STRETCH * rate)
    return [s for s in stretches if s.stop - s.start >= least] or [slice(0, len(t))]
