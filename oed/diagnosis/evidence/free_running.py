"""Disturbances that keep their own time: a machine next door, a fan, the mains.

They are a line in the spectrum of what repetitions of one motion differ by. Noise has a smooth
spectrum of whatever colour: against its local level the power of a frequency is exponentially
distributed (Percival and Walden 1993, "Spectral Analysis for Physical Applications", chapter 10).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.ndimage import median_filter
from scipy.stats import chi2

LEVEL = 1e-3  # chance of a line in noise, over all frequencies and joints
LEAST_SHARE = 0.03  # of the variance between repetitions that a line worth a word carries
LOWEST = 0.3  # [Hz]: slower is a drift
NEIGHBOURS = 41  # frequencies whose median is the local level
PADDING = 2  # ratio of transform to signal length: a line may lie between two frequencies


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


def find_lines(
    stretches: Sequence[Float[ndarray, "_ joints"]], rate: float, highest: float
) -> tuple[Line, ...]:
    """The clearest line of every joint that has one.

    Args:
        stretches: What repetitions differ by, one evenly sampled array a recording [N m].
        rate: [Hz].
        highest: Frequency up to which to look [Hz].
    """
    if not stretches:
        return ()
    joints = stretches[0].shape[1]
    length = PADDING * max(len(x) for x in stretches)
    frequency = np.fft.rfftfreq(length, 1 / rate)
    inside = (frequency >= LOWEST) & (frequency <= highest)
    if not inside.any():
        return ()
    tests = joints * int(inside.sum())
    found = []
    for joint in range(joints):
        series = [x[:, joint] for x in stretches]
        excess = np.sum([_over_local_level(x, length)[inside] for x in series], axis=0)
        peak = int(np.argmax(excess))
        p_value = min(1.0, tests * float(chi2.sf(2 * excess[peak], 2 * len(series))))
        at = float(frequency[inside][peak])
        amplitude, share = _size(series, rate, at)
        if p_value < LEVEL and share >= LEAST_SHARE:
            found.append(Line(joint, at, amplitude, share, p_value))
    return tuple(found)


def _over_local_level(x: Float[ndarray, " samples"], length: int) -> Float[ndarray, " frequencies"]:
    """Power over what the median of its neighbours makes expect; exponential in noise."""
    # Colour that falls within a neighbourhood would lift its lower end: one lag takes it off.
    plain = x[1:] - float(x[1:] @ x[:-1]) / max(float(x @ x), 1e-300) * x[:-1]
    power = np.abs(np.fft.rfft(plain * np.hanning(len(plain)), length)) ** 2
    level = median_filter(power, size=PADDING * NEIGHBOURS, mode="nearest") / np.log(2)
    return power / np.maximum(level, 1e-300)


def _size(
    series: Sequence[Float[ndarray, " samples"]], rate: float, frequency: float
) -> tuple[float, float]:
    """Amplitude of a sinusoid, its phase free in every stretch, and its share of the variance."""
    carried = whole = 0.0
    for x in series:
        turn = 2 * np.pi * frequency * np.arange(len(x)) / rate
        waves = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        fitted = waves @ np.linalg.lstsq(waves, x, rcond=None)[0]
        carried, whole = carried + float(fitted @ fitted), whole + float(x @ x)
    samples = sum(len(x) for x in series)
    return float(np.sqrt(2 * carried / samples)), carried / max(whole, 1e-300)
