"""Where the motion of a log ends in frequency: beyond it nothing was asked of the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import convolve

from oed.experiment.preparation.fresh import fresh_samples
from oed.experiment.recording import Recording
from oed.experiment.signals.resampling import resample, uniform_grid

LOWEST_CUTOFF = 1.0  # [Hz]
HIGHEST_CUTOFF = 100.0  # [Hz] beyond any arm's motion
CUTOFFS_PER_OCTAVE = 8
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
    q = resample(recording.t[fresh], recording.q[fresh], grid)
    # Second differences and a taper: an open motion's end points would leak over the band.
    acceleration = np.diff(q, n=2, axis=0) * rate**2
    taper = np.hanning(len(acceleration))[:, None]
    energy = np.abs(np.fft.rfft(acceleration * taper, axis=0)) ** 2 / rate
    band = np.searchsorted(edges, np.fft.rfftfreq(len(acceleration), 1 / rate))
    power = np.zeros((len(edges) + 1, recording.n))
    np.add.at(power, band, energy)
    return power[:-1]
