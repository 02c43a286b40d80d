"""Disturbances that keep their own time: a machine next door, a fan, the mains.

They are a line in the spectrum of what repetitions of one motion differ by. Noise has a smooth
spectrum of whatever colour: against its local level the power of a frequency is exponentially
distributed (Percival and Walden 1993, "Spectral Analysis for Physical Applications", chapter 10).

Where no motion is repeated, a line of what the model leaves may be the motion's. Then it counts
where the motion itself has none, in all recordings at once, carries much of what is left, and is
larger than all that the motion makes expect at its frequency.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.ndimage import median_filter
from scipy.stats import chi2

from oed.diagnosis.evidence.differing import PADDING, Differing
from oed.experiment.preparation.prepared import mean_at_each, places_in_period

# Chance of a line in white noise, over all frequencies and joints. Where colour changes within a
# neighbourhood the chance is up to some hundred times that.
LEVEL = 1e-5
LEAST_SHARE = 0.03  # of the variance between repetitions that a line worth a word carries
SLOW = 0.3  # [Hz], below which a drift of no one frequency has peaks of its own,
MUCH = 0.3  # and a line must carry this share; so must one of a motion that is not repeated
OWN = 8.0  # power over its local level, from which on the predicted torque has a line of its own
CYCLES = 10  # in the longest recording: with fewer nothing is clear, and nothing slow is a line
NEIGHBOURS = 41  # frequencies whose median is the local level
FINER = 17  # frequencies about a peak among which the line that carries most is looked for
SEEN = 0.2  # share of a frequency's power that is left between repetitions if it is to be judged


@dataclass(frozen=True)
class Line:
    """A sinusoid of one joint's torque that does not follow the motion.

    Attributes:
        joint: Index.
        frequency: [Hz].
        amplitude: [N m].
        share: Of the variance between repetitions.
        p_value: Over all frequencies and joints.
    """

    joint: int
    frequency: float
    amplitude: float
    share: float
    p_value: float

    @property
    def label(self) -> str:
        """In words."""
        return f"{self.amplitude:.2g} sin(2 pi {self.frequency:.4g} t + phase)"


def find_lines(recordings: Sequence[Differing], rate: float, highest: float) -> tuple[Line, ...]:
    """The clearest line of every joint that has one.

    Args:
        recordings: Of repeated motions, or of others.
        rate: [Hz].
        highest: Frequency up to which to look [Hz].
    """
    if not recordings:
        return ()
    joints = recordings[0].torque.shape[1]
    longest = max(len(r.torque) for r in recordings)
    length = PADDING * longest
    frequency = np.fft.rfftfreq(length, 1 / rate)
    lowest, clear = sorted((SLOW, CYCLES * rate / longest))
    inside = (frequency >= lowest) & (frequency <= highest)
    if not inside.any():
        return ()
    tests = joints * int(inside.sum())
    found = []
    for joint in range(joints):
        excess = np.sum([_excess(r, joint, length)[inside] for r in recordings], axis=0)
        peak = int(np.argmax(excess))
        p_value = min(1.0, tests * float(chi2.sf(2 * excess[peak], 2 * len(recordings))))
        if p_value >= LEVEL:
            continue
        near = frequency[inside][peak] + frequency[1] * np.linspace(-PADDING, PADDING, FINER)
        lines = [(*_size(recordings, joint, float(f) / rate), float(f)) for f in near]
        share, amplitude, at = max(lines)
        expected = [
            dataclasses.replace(r, torque=r.predicted)
            for r in recordings
            if r.predicted is not None
        ]
        if expected and amplitude <= _size(expected, joint, at / rate)[1]:
            continue
        if share >= (LEAST_SHARE if at >= clear and not expected else MUCH):
            found.append(Line(joint, at, amplitude, share, p_value))
    return tuple(found)


def _excess(recording: Differing, joint: int, length: int) -> Float[ndarray, " frequencies"]:
    """Power over its local level, none where the motion itself has a line."""
    excess = _over_local_level(recording.torque[:, joint], length, recording.period)
    if recording.predicted is not None:
        own = _over_local_level(recording.predicted[:, joint], length, recording.period)
        excess[own > OWN] = 0.0
    return excess


def _over_local_level(
    x: Float[ndarray, " samples"], length: int, period: float
) -> Float[ndarray, " frequencies"]:
    """Power over what the median of its neighbours makes expect; exponential in noise.

    Zero where the mean over the repetitions, of so many samples each, took most of the power.
    """
    # Colour that falls within a neighbourhood would lift its lower end: one lag takes it off.
    plain = x[1:] - float(x[1:] @ x[:-1]) / max(float(x @ x), 1e-300) * x[:-1]
    window = np.hanning(len(plain))
    power = np.abs(np.fft.rfft(plain * window, length)) ** 2
    share = _left_between(window, length, period)
    seen = share > SEEN
    even = power[seen] / share[seen]
    level = median_filter(even, size=PADDING * NEIGHBOURS, mode="nearest") / np.log(2)
    excess = np.zeros(len(power))
    excess[seen] = even / np.maximum(level, 1e-300)
    return excess


def _left_between(
    window: Float[ndarray, " samples"], length: int, period: float
) -> Float[ndarray, " frequencies"]:
    """Share of white noise's power that is left when the mean over repetitions is taken off.

    Nothing at the motion's own frequencies and most between them: of noise e, the transform of
    w (e - mean of e over R repetitions) has the power of the window w's correlations c at whole
    periods T, c(0) - sum over m of c(m T) cos(2 pi f m T) / R.
    """
    if not np.isfinite(period):
        return np.ones(length // 2 + 1)
    repetitions = max(1, round(len(window) / period))
    turn = 2 * np.pi * np.fft.rfftfreq(length)  # [rad a sample]
    taken = np.zeros(len(turn))
    for m in range(repetitions):
        lag = round(m * period)
        both = 2 if m else 1  # signs of m
        taken += both * (window[lag:] @ window[: len(window) - lag]) * np.cos(turn * lag)
    return 1 - taken / repetitions / float(window @ window)


def _size(recordings: Sequence[Differing], joint: int, frequency: float) -> tuple[float, float]:
    """Share of the variance that a sinusoid carries, its phase free in every stretch, and its size.

    What repetitions do not differ by is taken off the sinusoid too.

    Args:
        recordings: What is left of them.
        joint: Whose torque.
        frequency: [cycles a sample].
    """
    carried = whole = squares = 0.0
    for r in recordings:
        x = r.torque[:, joint]
        turn = 2 * np.pi * frequency * np.arange(len(x))
        waves = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        if np.isfinite(r.period):
            waves = waves - mean_at_each(waves, places_in_period(len(x), r.period))
        sizes = np.linalg.lstsq(waves, x, rcond=None)[0]
        carried, whole = carried + float(np.sum((waves @ sizes) ** 2)), whole + float(x @ x)
        squares += float(sizes @ sizes) * len(x)
    samples = sum(len(r.torque) for r in recordings)
    return carried / max(whole, 1e-300), float(np.sqrt(squares / samples))
