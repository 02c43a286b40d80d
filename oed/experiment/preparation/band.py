"""The frequency band in which both position and torque can be trusted.

A torque kept where the position is only noise shows accelerations that the regressor cannot
have seen, and they repeat with the motion: a false lack of fit. So the model's columns and the
torque pass one and the same filter, and its cut-off is where the position's signal ends.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.interpolate import CubicSpline
from scipy.signal import firwin, welch

from oed.experiment.signals.differentiation import spline_derivative, spline_through
from oed.experiment.signals.lowpass import lowpass
from oed.experiment.signals.moving_sum import moving_sum

SIGNAL_TO_NOISE = 4.0  # least ratio of the acceleration's power to that of encoder noise
NOISE_ONLY = 0.3  # of the rate, above which no arm moves and the position is noise
# The stretches in which motion is held against noise: from 1 Hz to short of the Nyquist frequency.
LOWEST, HIGHEST, STEPS = 1.0, 0.45, 60  # [Hz], of the rate
OVERLAP = 1.1  # ratio by which each is wider on both sides: the lowest hold few frequencies
SMOOTHING = 3.0  # the position's own filter, in units of the band: it must not touch the band
ACCELERATION_CUTOFF = (
    2.0  # an acceleration's filter, in units of where motion ends: it must not touch it
)
EDGE = 0.05  # [s] cut at each end besides the filter's reach, where smoothing has not settled
# Of the cut-off; the filter's length is 3.3 / transition width (Hamming). At half of it the filter reached
# a third of a second beyond each end at 10 Hz, and a log of a few seconds lost a tenth of its motion:
# held-out errors of the measured seven-joint arm rose from 0.017 to 0.023 of the torque.
TRANSITION = 1.0
# Of the fine grid, over the cut-off: friction's steps lie within half a sample, and gears, whose
# resonance may lie beyond the band, are followed from sample to sample.
FINE_PER_CUTOFF = 25.0
DENSE = 500.0  # [Hz] of a fine grid that shows any moment well
NEARLY = 0.02  # share of either by which a fine grid may fall short of it
PHASE = 0.02  # of a fine sample, by which a repetition may begin beside one
ALIASING = 0.4  # of a coarser grid's rate, to which a torque is low-passed before it is thinned
BLOCK = 0.5  # [s] of a residual that go together: it is correlated over the band's inverse
# Analysis rate over cut-off. Of what lies beyond Nyquist an eighth is left, soon a hundredth, and it folds
# alike in torque and model.
SAMPLES_PER_CUTOFF = 2.5


@dataclass(frozen=True)
class Band:
    """A low-pass and decimation, the same for torque and model.

    Attributes:
        rate: Of the fine grid on which columns are evaluated [Hz].
        factor: Fine samples per analysis sample.
        cutoff: Frequency of half amplitude [Hz].
        smoothing: Cut-off of the position's own smoothing [Hz].
        acceleration_cutoffs: Cut-off of each joint's acceleration [Hz]; that of the smoothing if empty.
        logged: Samples of the log's own grid to one of the fine grid. Positions are smoothed where
            they were logged: only there is what encoders err white.
    """

    rate: float
    factor: int
    cutoff: float
    smoothing: float
    acceleration_cutoffs: tuple[float, ...] = ()
    logged: int = 1

    @property
    def logged_rate(self) -> float:
        """Of the grid on which positions are smoothed [Hz]."""
        return self.rate * self.logged

    @property
    def analysis_rate(self) -> float:
        """Rate of the filtered rows [Hz]."""
        return self.rate / self.factor

    @cached_property
    def taps(self) -> Float[ndarray, " taps"]:
        """Symmetric impulse response of unit sum."""
        length = 2 * int(np.ceil(1.65 * self.rate / (TRANSITION * self.cutoff))) + 1
        return np.asarray(firwin(length, self.cutoff, fs=self.rate))

    @property
    def reach(self) -> int:
        """Fine samples on each side that a filtered one depends on."""
        return len(self.taps) // 2

    def rows(self, samples: int) -> int:
        """Analysis rows that `samples` fine ones give."""
        return max(0, (samples - 1 - 2 * self.reach) // self.factor + 1)

    def instants(self, t: Float[ndarray, " samples"]) -> Float[ndarray, " rows"]:
        """Times of the filtered rows [s]."""
        return t[self.reach : len(t) - self.reach : self.factor]

    @property
    def cut(self) -> int:
        """Samples of the fine grid that are cut at each end."""
        return int(np.ceil(self.edge * self.rate))

    @property
    def lead(self) -> float:
        """Time from a log's first sample to the first that is used [s]."""
        return self.cut / self.rate

    @property
    def edge(self) -> float:
        """Time at each end in which the smoothing has not settled [s]."""
        return max(EDGE, *(1 / cutoff for cutoff in self.acceleration_cutoffs), 1 / self.smoothing)

    def thinned(self, fastest: float, periods: Sequence[float] = ()) -> Band:
        """The same on a fine grid no denser than effects ask for.

        Args:
            fastest: Frequency on the fine grid that must not fold into the band [Hz].
            periods: Of repeated motions [s]: samples of all repetitions must lie at the same phases.
        """
        # What folds into the band leaves no room to fall short.
        unfolded = fastest + self.cutoff * (1 + TRANSITION)
        needed = max((1 - NEARLY) * FINE_PER_CUTOFF * self.cutoff, unfolded)
        turns = np.array(periods) * self.rate
        for step in range(int(self.rate / needed), 1, -1):
            in_phase = np.abs(turns / step - np.round(turns / step)) < PHASE
            is_dense = self.rate / step >= (1 - NEARLY) * DENSE
            # The rows stay where they are, or lie a little nearer on a grid that is dense in any case.
            if in_phase.all() and (self.factor % step == 0 or is_dense):
                return dataclasses.replace(
                    self, rate=self.rate / step, factor=self.factor // step, logged=step
                )
        return self

    def thin(self, torque: Float[ndarray, "logged joints"]) -> Float[ndarray, "samples joints"]:
        """A torque on the log's grid, on the fine one."""
        if self.logged == 1:
            return torque
        return lowpass(torque, self.logged_rate, ALIASING * self.rate)[:: self.logged]

    def as_logged(
        self, smooth: Float[ndarray, " samples *columns"]
    ) -> Float[ndarray, " logged *columns"]:
        """What is smooth on the fine grid, on the log's."""
        if self.logged == 1:
            return smooth
        places = np.arange((len(smooth) - 1) * self.logged + 1) / self.logged
        return CubicSpline(np.arange(len(smooth)), smooth)(places)

    def differentiate(
        self, q: Float[ndarray, "logged joints"]
    ) -> tuple[
        Float[ndarray, "samples joints"],
        Float[ndarray, "samples joints"],
        Float[ndarray, "samples joints"],
    ]:
        """Smooth positions, velocities and accelerations on the fine grid.

        An acceleration holds what its encoder knows better than noise: the noise of a regressor
        makes the parameters too small, and what they miss looks like a spring (Carroll, Ruppert,
        Stefanski and Crainiceanu 2006, "Measurement Error in Nonlinear Models", chapter 4). The
        velocity keeps more, since its sign must not come late.
        """
        rate, kept = self.logged_rate, slice(None, None, self.logged)
        smooth = lowpass(q, rate, self.smoothing)
        calm = smooth.copy()
        for joint, cutoff in enumerate(self.acceleration_cutoffs):
            if cutoff < self.smoothing:
                calm[:, joint] = lowpass(q[:, joint], rate, cutoff)
        both, t = spline_through(np.stack([smooth, calm], axis=1), rate), np.arange(len(q)) / rate
        return smooth[kept], both(t[kept], 1)[:, 0].copy(), both(t[kept], 2)[:, 1].copy()

    def differentiate_velocity(
        self, dq: Float[ndarray, "logged joints"]
    ) -> tuple[Float[ndarray, "samples joints"], Float[ndarray, "samples joints"]]:
        """Smooth velocities and accelerations on the fine grid of velocities that were logged."""
        rate, kept = self.logged_rate, slice(None, None, self.logged)
        smooth = lowpass(dq, rate, self.smoothing)
        return smooth[kept], spline_derivative(smooth, rate)[kept]

    def apply(self, fine: Float[ndarray, " samples *columns"]) -> Float[ndarray, " rows *columns"]:
        """Filter without phase and keep every `factor`-th row, the unsettled ends cut away."""
        return moving_sum(fine, self.taps, self.factor)


@dataclass(frozen=True)
class PositionNoise:
    """What is noise in measured positions.

    Attributes:
        density: (n,) one-sided spectral density [rad^2/Hz].
        reach: (n,) frequency up to which the motion exceeds it everywhere [Hz].
        end: (n,) frequency beyond which the motion exceeds it nowhere [Hz].
    """

    density: Float[ndarray, " joints"]
    reach: Float[ndarray, " joints"]
    end: Float[ndarray, " joints"]


def position_noise(positions: Sequence[Float[ndarray, "_ joints"]], rate: float) -> PositionNoise:
    """Spectral density of encoder noise, and where motion exceeds it.

    The noise is read off the upper part of the band, where arms do not move, and taken for
    white; second differences keep the motion's large slow part from leaking over it.

    Args:
        positions: Uniformly sampled positions, one array a recording [rad or m].
        rate: [Hz].
    """
    length = int(min(min(len(q) for q in positions) - 2, 4 * rate))
    accelerations = (np.diff(q, n=2, axis=0) for q in positions)
    spectra = [
        welch(a, fs=rate, nperseg=length, axis=0, detrend="constant", window="hann")
        for a in accelerations
    ]
    frequency = spectra[0][0]
    power = np.mean([each for _, each in spectra], axis=0)
    # |1 - z^-1|^4 of the second difference.
    shape = (2 - 2 * np.cos(2 * np.pi * frequency / rate)) ** 2
    upper = frequency > NOISE_ONLY * rate
    density = np.median(power[upper] / shape[upper, None], axis=0)
    moved = np.array([LOWEST])  # slower than that there is motion in any case
    exceeded = np.ones((1, len(density)), dtype=bool)
    for lower, higher in itertools.pairwise(np.geomspace(LOWEST, HIGHEST * rate, STEPS)):
        inside = (frequency >= lower / OVERLAP) & (frequency <= higher * OVERLAP)
        if inside.any():
            noise = density * shape[inside].mean()
            above = power[inside].mean(axis=0) >= SIGNAL_TO_NOISE * noise
            moved, exceeded = np.append(moved, higher), np.vstack([exceeded, above])
    unbroken = np.logical_and.accumulate(exceeded)
    reach, end = (np.max(moved[:, None] * where, axis=0) for where in (unbroken, exceeded))
    return PositionNoise(density, reach, end)


def choose_band(noise: PositionNoise, rate: float, lowest: float, highest: float) -> Band:
    """The widest band in which every joint's motion stands out of its encoder's noise.

    Args:
        noise: Of the positions.
        rate: Of these [Hz].
        lowest: Least cut-off [Hz].
        highest: Largest cut-off [Hz].
    """
    cutoff = float(np.clip(noise.reach.min(), lowest, highest))
    cutoff = min(cutoff, rate / (2 * SAMPLES_PER_CUTOFF))
    factor = max(1, int(rate / (SAMPLES_PER_CUTOFF * cutoff)))
    smoothing = min(SMOOTHING * cutoff, 0.4 * rate)
    acceleration_cutoffs = np.where(
        ACCELERATION_CUTOFF * noise.end < cutoff, ACCELERATION_CUTOFF * noise.end, smoothing
    )
    return Band(rate, factor, cutoff, smoothing, tuple(acceleration_cutoffs.tolist()))
