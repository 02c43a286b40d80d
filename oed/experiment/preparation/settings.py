"""One band for all recordings of a log, chosen from their positions: for every command the same."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.experiment.preparation.band import (
    SAMPLES_PER_CUTOFF,
    SIGNAL_TO_NOISE,
    TRANSITION,
    Band,
    PositionNoise,
    choose_band,
    position_noise,
)
from oed.experiment.preparation.fresh import fresh_samples
from oed.experiment.preparation.motion_band import search_cutoff
from oed.experiment.preparation.torque_end import torque_end
from oed.experiment.preparation.uniform import between_gaps, uniform, uniform_rate
from oed.experiment.recording import Recording

VelocitySource = Literal["differentiated", "logged"]

LEAST_BAND = 8.0  # [Hz] in which friction's steps at reversals are still seen
HIGHEST_BAND = 30.0  # [Hz] beyond which gears ring and no rigid arm is left to identify
SHORTEST_WAVE = 260.0  # [1/turn] of a torque ripple and its first overtone


@dataclass(frozen=True)
class ProcessingSettings:
    """How recordings become motion and torque; `choose_settings` proposes one.

    Attributes:
        band: Filter of torque and model, and the rates.
        noise: Of the positions.
        velocity: "differentiated" from the smoothed position, or the "logged" dq.
        filtered_at: Where the torque was filtered before it was logged, if the band ends by it [Hz].
        reasons: One line a setting, why it was chosen.
    """

    band: Band
    noise: PositionNoise = field(repr=False, compare=False)
    velocity: VelocitySource = "differentiated"
    filtered_at: float | None = field(default=None, compare=False)
    reasons: tuple[str, ...] = field(default=(), compare=False)

    @property
    def cutoff(self) -> float:
        """Frequency of half amplitude [Hz]."""
        return self.band.cutoff

    @property
    def rate(self) -> float:
        """Of the uniform grid that logs are brought to [Hz]."""
        return self.band.logged_rate

    def with_velocity(self, velocity: VelocitySource, reason: str) -> ProcessingSettings:
        """The same with another velocity, and why."""
        kept = tuple(line for line in self.reasons if not line.startswith("velocity"))
        return dataclasses.replace(self, velocity=velocity, reasons=(*kept, f"velocity: {reason}"))

    def record(self) -> dict[str, object]:
        """Plain values, as estimate.json has them."""
        return {
            "rate": self.rate,
            "model_rate": self.band.rate,
            "cutoff": self.cutoff,
            "decimation": self.band.factor * self.band.logged,
            "trim": self.band.lead + self.band.reach / self.band.rate,
            "velocity": self.velocity,
            "reasons": self.reasons,
        }


def choose_settings(
    recordings: Sequence[Recording], *, cutoff: float | None = None
) -> ProcessingSettings:
    """The widest band that signal and noise justify, the same for torque and model.

    Of a test recording only the times count, or it would have a say in what is found.

    Args:
        recordings: Of one data set, with one for estimation at least.
        cutoff: Of the band, if it is given [Hz].

    Raises:
        ValueError: If no recording is for estimation, or the cut-off is beyond what the rate holds.
    """
    if not any(r.role == "estimation" for r in recordings):
        raise ValueError("no recording has the role estimation: give it to one in dataset.toml")
    rate = uniform_rate(recordings)
    seen = [r for r in recordings if r.role != "test"]
    positions, torques = _stretches(seen, rate)
    noise = position_noise(positions, rate)
    lowest, highest, why = LEAST_BAND, HIGHEST_BAND, _why(noise)
    end = torque_end(torques, rate)
    passed = end / (1 - TRANSITION / 2)  # all of the torque: the filter begins where it ends
    if cutoff is not None:
        slowest, fastest = 1 / max(r.duration for r in recordings), rate / (2 * SAMPLES_PER_CUTOFF)
        if not slowest < cutoff <= fastest:
            raise ValueError(
                f"cut-off {cutoff:g} Hz must lie between {slowest:.3g} Hz, of which the longest recording "
                f"holds one period, and {fastest:g} Hz, which the rate of {rate:g} Hz carries"
            )
        lowest, highest, why = cutoff, cutoff, "given"
    elif all(r.repetitions < 2 for r in recordings if r.role == "estimation"):
        highest = min(highest, _motion_band(recordings, rate))
    is_filtered = cutoff is None and passed < highest
    if is_filtered:
        lowest, highest, why = min(lowest, passed), passed, _why_filtered(end)
    band = choose_band(noise, rate, lowest, highest)
    periods = [p for p in map(period_of, recordings) if p is not None]
    band = band.thinned(_fastest_wave(band, positions), periods)
    return ProcessingSettings(
        band,
        noise,
        filtered_at=end if is_filtered else None,
        reasons=_reasons(recordings, band, why),
    )


def period_of(recording: Recording) -> float | None:
    """Of its motion [s]; None where it is not repeated."""
    if recording.repetition is None or recording.repetitions < 2:
        return None
    if recording.period is not None:
        return recording.period
    _, first = np.unique(recording.repetition, return_index=True)
    return float(np.median(np.diff(recording.t[np.sort(first)])))


def _stretches(recordings: Sequence[Recording], rate: float) -> tuple[list[ndarray], list[ndarray]]:
    """Positions and torques on a uniform grid, between gaps of the log."""
    positions, torques = [], []
    for recording in recordings:
        signals = uniform(recording, rate)
        for stretch in between_gaps(recording, signals.t, rate):
            positions.append(signals.q[stretch])
            torques.append(signals.tau[stretch])
    return positions, torques


def _fastest_wave(band: Band, positions: Sequence[Float[ndarray, "_ joints"]]) -> float:
    """Frequency at which the shortest wave of position that has a name is crossed [Hz]."""
    speed = max(float(np.abs(band.differentiate(q)[1]).max()) for q in positions)
    return SHORTEST_WAVE * speed / (2 * np.pi)


def _motion_band(recordings: Sequence[Recording], rate: float) -> float:
    """Twice the frequency below which motion lies [Hz], at least `LEAST_BAND`.

    Without repetitions nothing tells noise from what drives and loops add above the motion.
    """
    estimation = tuple(r for r in recordings if r.role == "estimation")
    shortest = min(recording.duration for recording in recordings)
    return max(LEAST_BAND, 2 * search_cutoff(estimation, rate, shortest).band_edge)


def _why(noise: PositionNoise) -> str:
    joint = int(np.argmin(noise.reach))
    return (
        f"up to {noise.reach[joint]:.3g} Hz the acceleration of every joint has {SIGNAL_TO_NOISE:g} times "
        f"the power of its encoder's noise, joint {joint + 1} no further; from {LEAST_BAND:g} Hz, in "
        f"which friction's steps are seen, to {HIGHEST_BAND:g} Hz or, where no motion is repeated, "
        "twice the motion's own band"
    )


def _why_filtered(end: float) -> str:
    return (
        f"beyond {end:.3g} Hz the torque's spectrum is nowhere a thousandth of its largest value: it was "
        "filtered before it was logged, and tells nothing there"
    )


def _reasons(recordings: Sequence[Recording], band: Band, why: str) -> tuple[str, ...]:
    steps = [np.diff(r.t) for r in recordings]
    shortest, longest = (
        1e3 * f(s) for f, s in ((min, map(np.min, steps)), (max, map(np.max, steps)))
    )
    repeats = 1 - np.mean(np.concatenate([fresh_samples(r) for r in recordings]))
    return (
        (
            f"uniform rate {band.logged_rate:g} Hz: that of the slowest log, at most 1 kHz "
            f"(steps from {shortest:.4g} to {longest:.4g} ms)"
        ),
        f"cut-off {band.cutoff:.3g} Hz: {why}",
        (
            f"the model is evaluated at {band.rate:.4g} Hz, filtered like the torque (finite impulse "
            f"response, no phase), and one row in {band.factor} is kept, {band.analysis_rate:.4g} Hz"
        ),
        f"{band.lead + band.reach / band.rate:.3g} s are cut at each end, which the filter reaches beyond",
        "velocity and acceleration: of the spline through the smoothed position",
        f"rows that repeat their predecessor: {100 * repeats:.1f} %, left out",
    )
