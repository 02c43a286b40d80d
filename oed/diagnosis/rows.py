"""Whitened, weighted rows of several recordings: what every statistic here is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.diagnosis.prepare import Prepared
from oed.diagnosis.whitening import Autoregression

# Standard deviation of a reversal's time besides the velocity's noise, in units of one over the
# smoothing cut-off: the acceleration jumps there, and smoothing rounds the jump.
REVERSAL_ROUNDING = 0.1
HARMFUL = 0.3  # share of the noise at which a badly timed reversal spoils its estimate
STANDSTILL = 2.0  # velocities below this many sigmas have no sign


@dataclass(frozen=True)
class Rows:
    """Recordings with the noise that whitens them.

    Attributes:
        prepared: The recordings, one after another.
        noise: Autoregression of each joint.
        scales: Standard deviation of each recording's noise, in units of the autoregression's.
        weights: (R, n) by which whitened rows are multiplied: below one where the sign of
            the velocity is uncertain, zero where a row has no past.
    """

    prepared: tuple[Prepared, ...]
    noise: tuple[Autoregression, ...]
    scales: tuple[float, ...]
    weights: Float[ndarray, "rows joints"]

    @property
    def count(self) -> int:
        """Rows R of one joint."""
        return len(self.weights)

    @property
    def starts(self) -> Int[ndarray, " recordings_and_end"]:
        """First row of each recording, and the end."""
        return np.concatenate([[0], np.cumsum([p.rows for p in self.prepared])])

    def whiten(
        self, blocks: Sequence[Float[ndarray, "_ columns"]], joint: int
    ) -> Float[ndarray, "rows columns"]:
        """White rows of one joint from filtered blocks, one a recording."""
        noise = self.noise[joint]
        white = np.concatenate(
            [noise.whiten(block) / scale for block, scale in zip(blocks, self.scales, strict=True)]
        )
        return white * self.weights[:, joint, None]

    def whiten_fine(
        self, blocks: Sequence[Float[ndarray, "_ columns"]], joint: int
    ) -> Float[ndarray, "rows columns"]:
        """White rows of one joint from columns on the fine grids."""
        filtered = [p.band.apply(b) for p, b in zip(self.prepared, blocks, strict=True)]
        return self.whiten(filtered, joint)

    def torque(self) -> Float[ndarray, "joints rows"]:
        """White torque of every joint."""
        joints = self.weights.shape[1]
        return np.stack(
            [self.whiten([p.torque[:, [j]] for p in self.prepared], j)[:, 0] for j in range(joints)]
        )


def weigh(
    prepared: tuple[Prepared, ...],
    noise: tuple[Autoregression, ...],
    coulomb: Float[ndarray, " joints"],
    scales: tuple[float, ...] | None = None,
    dilution: Float[ndarray, " joints"] | None = None,
) -> Rows:
    """Rows whose weights know how badly each reversal is timed.

    A sign that turns dt too late is an error of 2 F_c for dt. Passed through the band and the
    whitening filter it gives each row near the reversal an extra variance.

    Args:
        prepared: The recordings.
        noise: Autoregression of each joint.
        coulomb: (n,) height of the torque step at a reversal, one side [N m].
        scales: As in `Rows`; all 1 if None.
        dilution: (n,) correlated rows that count as one, where noise is not whitened.
    """
    scales = (1.0,) * len(prepared) if scales is None else scales
    weights = []
    for recording, scale in zip(prepared, scales, strict=True):
        column = [
            _weights_of(recording, joint, noise[joint].with_scale(scale), float(coulomb[joint]))
            for joint in range(len(noise))
        ]
        weights.append(np.stack(column, axis=1))
    stacked = np.concatenate(weights)
    if dilution is not None:
        stacked = stacked / np.sqrt(dilution)
    return Rows(prepared, noise, scales, stacked)


def trusted_samples(
    recording: Prepared, joint: int, coulomb: float, deviation: float
) -> Bool[ndarray, " samples"]:
    """Fine samples whose filtered neighbourhood shows noise rather than a badly timed reversal.

    Args:
        recording: On its fine grid.
        joint: Index.
        coulomb: Height of the friction step [N m].
        deviation: Standard deviation of the noise in the band [N m].
    """
    band = recording.band
    turns, timing = _reversals(recording, joint)
    harmful = 2 * abs(coulomb) * timing * 2 * band.cutoff > HARMFUL * deviation
    trusted = np.ones(len(recording.motion), dtype=bool)
    reach = int(np.ceil(band.rate / band.cutoff))
    for turn in turns[harmful]:
        trusted[max(0, turn - reach) : turn + reach + 2] = False
    sigma = max(float(recording.sign_noise[joint]), 1e-12)
    return trusted & recording.recorded & ~_standing(recording.motion.dq[:, joint], sigma, reach)


def reversal_shapes(recording: Prepared, joint: int) -> Float[ndarray, "samples 2"]:
    """An impulse and a narrow odd bump at each reversal, on the fine grid."""
    band = recording.band
    velocity = recording.motion.dq[:, joint]
    turns, _ = _reversals(recording, joint)
    sigma = max(float(recording.sign_noise[joint]), 1e-12)
    impulses = np.zeros(len(velocity))
    impulses[turns] = np.sign(velocity[turns + 1] - velocity[turns])
    slope = np.abs(velocity[turns + 1] - velocity[turns]) * band.rate
    typical = float(np.median(slope)) if len(turns) else 0.0
    width = max(3 * sigma, REVERSAL_ROUNDING * typical / band.smoothing)
    bump = np.sign(velocity) * np.exp(-np.abs(velocity) / width)
    return np.stack([impulses, bump], axis=1)


def _reversals(
    recording: Prepared, joint: int
) -> tuple[Int[ndarray, " turns"], Float[ndarray, " turns"]]:
    """Samples before a change of sign, and the standard deviation of its time [s]."""
    band = recording.band
    velocity = recording.motion.dq[:, joint]
    sigma = max(float(recording.sign_noise[joint]), 1e-12)
    turns = np.flatnonzero(np.signbit(velocity[1:]) != np.signbit(velocity[:-1]))
    slope = np.abs(velocity[turns + 1] - velocity[turns]) * band.rate
    timing = np.hypot(
        sigma / np.maximum(slope, sigma * band.smoothing), REVERSAL_ROUNDING / band.smoothing
    )
    return turns, timing


def _weights_of(
    recording: Prepared, joint: int, noise: Autoregression, coulomb: float
) -> Float[ndarray, " rows"]:
    band = recording.band
    velocity = recording.motion.dq[:, joint]
    sigma = max(float(recording.sign_noise[joint]), 1e-12)
    impulses = np.zeros(len(velocity))
    turns, timing = _reversals(recording, joint)
    # Squares add: several crossings within the velocity's noise are one uncertain stretch.
    np.maximum.at(impulses, turns, 2 * coulomb * timing * band.rate)
    error = noise.whiten(band.apply(impulses[:, None]))[:, 0]
    spread = np.maximum.reduce([np.abs(np.roll(error, k)) for k in (-1, 0, 1)])
    weights = 1 / np.sqrt(1 + spread**2)
    still = _standing(velocity, sigma, band.rate / band.cutoff)
    share = band.apply(still.astype(float)[:, None])[:, 0]
    weights[share > 0.05] = 0.0
    # A row is as good as the past that whitening reads.
    lacking = np.convolve(~recording.valid, np.ones(noise.order + 1))[: len(weights)]
    weights[lacking > 0.5] = 0.0
    weights[: noise.order] = 0.0
    return weights


def _standing(velocity: Float[ndarray, " samples"], sigma: float, shortest: float | int) -> ndarray:
    """Samples of stretches of at least `shortest` samples in which the velocity has no sign."""
    slow = np.abs(velocity) < STANDSTILL * sigma
    edges = np.flatnonzero(np.diff(slow, prepend=False, append=False))
    standing = np.zeros(len(velocity), dtype=bool)
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        if end - start >= shortest:
            standing[start:end] = True
    return standing
