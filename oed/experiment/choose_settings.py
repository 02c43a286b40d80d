"""Processing settings from the data themselves, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import convolve

from oed.experiment.dataset import DataSet
from oed.experiment.processing import (
    LEAST_TRIM,
    MOTION_BAND,
    SAMPLES_PER_CUTOFF,
    TRIM_PERIODS,
    ProcessingSettings,
    fresh_samples,
    suitable_decimation,
    suitable_trim,
)
from oed.experiment.recording import Recording
from oed.experiment.signals.resampling import resample, uniform_grid
from oed.experiment.stretches import split_at_gaps

LOWEST_CUTOFF = 1.0  # [Hz]
HIGHEST_CUTOFF = 100.0  # [Hz] beyond any arm's motion
CUTOFFS_PER_OCTAVE = 8
ORDER = 4  # of the one-way filter; higher orders ring
RATE_DIGITS = 3  # loggers run at 62.5 Hz, 125 Hz, 333 Hz, and their stamps jitter
PASSBAND_GAIN = 0.95  # of the filter, both passes, at the highest frequency that holds motion
SHORTEST = 8.0  # periods of the cut-off that must fit into the shortest recording


@dataclass(frozen=True)
class CutoffSearch:
    """How sensitive the acceleration is to the cut-off.

    Attributes:
        frequency: (F,) candidate cut-offs [Hz].
        sensitivity: (F, m) d log rms(acceleration) / d log(cut-off), by moving joint: large
            where motion is cut away, small where motion ends, large again in the noise.
        band_edge: The candidate at which its mean over the joints is least [Hz]: motion lies
            below it.
    """

    frequency: Float[ndarray, " candidates"]
    sensitivity: Float[ndarray, "candidates moving"]
    band_edge: float


def choose_settings(dataset: DataSet) -> ProcessingSettings:
    """Sensible settings for all recordings of a data set, from its estimation recordings.

    Raises:
        ValueError: If the data set has no recording for estimation, or one with gaps in its
            time has no stretch that is long enough.
    """
    # A leap across a gap would pass for fast motion.
    dataset = split_at_gaps(dataset)
    recordings = dataset.estimation
    if not recordings:
        raise ValueError(f"data set {dataset.name!r} has no recording with role estimation")
    rate, rate_reason = _choose_rate(recordings)
    shortest = min(recording.duration for recording in dataset.recordings)
    search = search_cutoff(recordings, rate, shortest)
    cutoff = _rounded(search.band_edge * (1 / PASSBAND_GAIN - 1) ** (-1 / (2 * ORDER)))
    repeats = 1 - np.mean(np.concatenate([fresh_samples(r) for r in recordings]))
    decimation = suitable_decimation(rate, cutoff)
    trim = suitable_trim(cutoff)
    least = float(search.sensitivity.mean(axis=1).min())
    passed = f"{100 * PASSBAND_GAIN:g} % at {search.band_edge:.3g} Hz"
    reasons = (
        rate_reason,
        (
            f"cut-off {cutoff:g} Hz: passes {passed}, where the acceleration depends least on it "
            f"(d log rms / d log cut-off = {least:.3f}); lower loses motion, higher adds noise"
        ),
        (
            f"filter: Butterworth, order {ORDER}, forward and backward, the same for torque and "
            f"model; position is smoothed at {MOTION_BAND:g} times the cut-off"
        ),
        (
            f"one sample in {decimation}, {rate / decimation:.4g} Hz: at least "
            f"{SAMPLES_PER_CUTOFF:g} a period of the cut-off"
        ),
        (
            f"trim {trim:.3g} s at each end, until the filter has settled: {TRIM_PERIODS:g} periods "
            f"of the cut-off, at least {LEAST_TRIM:g} s"
        ),
        "velocity and acceleration: of the spline through the smoothed position",
        f"rows that repeat their predecessor: {100 * repeats:.1f} %, left out",
        "interpolation: cubic, between the logged instants",
    )
    return ProcessingSettings(
        rate=rate,
        cutoff=cutoff,
        order=ORDER,
        decimation=decimation,
        trim=trim,
        reasons=reasons,
    )


def search_cutoff(recordings: tuple[Recording, ...], rate: float, shortest: float) -> CutoffSearch:
    """The cut-off on which the acceleration's rms depends least.

    With the position's power spectrum S, a cut-off fc lets A(fc) = integral of
    (2 pi f)^4 S(f) from 0 to fc through, so d log sqrt(A) / d log fc =
    fc (2 pi fc)^4 S(fc) / (2 A(fc)). While motion dominates, this falls as more of it is
    caught; white position noise makes it rise towards 5/2. The minimum lies between.

    Args:
        recordings: To take spectra of, weighted by their duration.
        rate: Uniform rate [Hz].
        shortest: Duration [s] of the shortest recording to be filtered.

    Raises:
        ValueError: If nothing moves.
    """
    highest = min(HIGHEST_CUTOFF, 0.2 * rate)
    lowest = min(max(LOWEST_CUTOFF, SHORTEST / shortest), highest / 2)
    octaves = np.log2(highest / lowest)
    edges = np.geomspace(lowest, highest, int(np.ceil(octaves * CUTOFFS_PER_OCTAVE)) + 1)
    power = np.zeros((len(edges), recordings[0].n))
    for recording in recordings:
        power += _power_in_bands(recording, rate, edges)
    below = np.cumsum(power, axis=0)
    width = np.log(edges[1] / edges[0])
    # A joint that stands still has no say.
    moving = below[-1] > 0
    if not moving.any():
        raise ValueError("no joint moves in the recordings for estimation")
    sensitivity = power[1:, moving] / (2 * width * below[1:, moving])
    # One octave smooths the lines of a multisine, between which nothing was excited.
    window = np.ones((CUTOFFS_PER_OCTAVE, 1)) / CUTOFFS_PER_OCTAVE
    smooth = convolve(sensitivity, window, mode="valid", method="direct")
    centre = np.sqrt(edges[:-1] * edges[1:])
    frequency = np.sqrt(centre[: len(smooth)] * centre[CUTOFFS_PER_OCTAVE - 1 :])
    best = frequency[int(smooth.mean(axis=1).argmin())]
    return CutoffSearch(frequency, smooth, band_edge=float(best))


def _power_in_bands(
    recording: Recording, rate: float, edges: Float[ndarray, " edges"]
) -> Float[ndarray, "edges joints"]:
    """Energy of the acceleration below edges[0], then between successive edges, by joint."""
    fresh = fresh_samples(recording)
    grid = uniform_grid(recording.t, rate)
    q = resample(recording.t[fresh], recording.q[fresh], grid, "linear")
    # Second differences and a taper: an open motion's end points would leak over the band.
    acceleration = np.diff(q, n=2, axis=0) * rate**2
    taper = np.hanning(len(acceleration))[:, None]
    energy = np.abs(np.fft.rfft(acceleration * taper, axis=0)) ** 2 / rate
    band = np.searchsorted(edges, np.fft.rfftfreq(len(acceleration), 1 / rate))
    power = np.zeros((len(edges) + 1, recording.n))
    np.add.at(power, band, energy)
    return power[:-1]


def _choose_rate(recordings: tuple[Recording, ...]) -> tuple[float, str]:
    """The finest rate [Hz] that was logged, to three digits, and the reason."""
    steps = [np.diff(recording.t) for recording in recordings]
    finest = min(float(np.median(step)) for step in steps)
    rate = float(f"{1 / finest:.{RATE_DIGITS}g}")
    shortest, longest = min(s.min() for s in steps), max(s.max() for s in steps)
    reason = (
        f"uniform rate {rate:g} Hz: the median step is {1e3 * finest:.4g} ms "
        f"(steps from {1e3 * shortest:.4g} to {1e3 * longest:.4g} ms)"
    )
    return rate, reason


def _rounded(value: float) -> float:
    """Two significant digits: more would pretend to a precision that no choice here has."""
    return float(f"{value:.2g}")
