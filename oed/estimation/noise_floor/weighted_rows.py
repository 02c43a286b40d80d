"""Whitened, weighted rows of several recordings: what every statistic here is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray
from scipy.ndimage import maximum_filter1d

from oed.estimation.noise_floor.autoregression import Autoregression
from oed.estimation.noise_floor.uncertain_sign import UncertainSign, uncertain_in
from oed.experiment.preparation.direction import direction_error, stopped
from oed.experiment.preparation.prepared import Prepared

HALF = 0.5  # of a row's window, from which on it is one of a stop


@dataclass(frozen=True)
class Rows:
    """Recordings with the noise that whitens them.

    Attributes:
        prepared: The recordings, one after another.
        noise: Autoregression of each joint.
        scales: Standard deviation of each recording's noise, in units of the autoregression's.
        weights: (R, n) by which whitened rows are multiplied: below one where the
            direction is uncertain, zero where a row has no past.
        uncertain: What uncertain directions hide of each recording's white rows, by joint; none if
            empty, or where the weights are for that.
    """

    prepared: tuple[Prepared, ...]
    noise: tuple[Autoregression, ...]
    scales: tuple[float, ...]
    weights: Float[ndarray, "rows joints"]
    uncertain: tuple[tuple[UncertainSign, ...], ...] = ()

    @property
    def counted(self) -> Float[ndarray, " joints"]:
        """(n,) rows of each joint that count."""
        lost = [[h.count for h in own] for own in self.uncertain if own]
        return np.sum(self.weights**2, axis=0) - np.sum(lost, axis=0)

    @property
    def count(self) -> int:
        """Rows R of one joint."""
        return len(self.weights)

    @cached_property
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
        return self.as_certain(white, joint)

    def as_certain(
        self, white: Float[ndarray, "rows columns"], joint: int
    ) -> Float[ndarray, "rows columns"]:
        """White rows of one joint, each made to count as far as it is certain."""
        told = white * self.weights[:, joint, None]
        for own, (a, b) in zip(self.uncertain, pairwise(self.starts), strict=False):
            if own:
                told[a:b] = own[joint].out_of(told[a:b])
        return told

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
    """Rows whose weights know where the direction of motion is uncertain.

    Friction of unknown sign, passed through the band and the whitening filter, gives each row
    near a reversal an extra variance.

    Args:
        prepared: The recordings.
        noise: Autoregression of each joint.
        coulomb: (n,) height of the torque step at a reversal, one side [N m].
        scales: As in `Rows`; all 1 if None.
        dilution: (n,) correlated rows that count as one, where noise is not whitened.
    """
    scales = (1.0,) * len(prepared) if scales is None else scales
    weights, uncertain = [], []
    for recording, scale in zip(prepared, scales, strict=True):
        scaled = [n.with_scale(scale) for n in noise]
        joints = list(enumerate(zip(scaled, coulomb.tolist(), strict=True)))
        # Whitening spreads the doubt of few rows over many; in repetitions all must count alike.
        if recording.period is None and any(n.order for n in noise):
            pairs = [uncertain_in(recording, j, n, c) for j, (n, c) in joints]
            uncertain.append(tuple(h for h, _ in pairs))
            weights.append(np.stack([w for _, w in pairs], axis=1))
            continue
        column = [_weights_of(recording, j, n, c) for j, (n, c) in joints]
        uncertain.append(())
        weights.append(_balanced(np.stack(column, axis=1), recording))
    stacked = np.concatenate(weights)
    if dilution is not None:
        stacked = stacked / np.sqrt(dilution)
    return Rows(prepared, noise, scales, stacked, tuple(uncertain))


def _balanced(
    weights: Float[ndarray, "rows joints"], recording: Prepared
) -> Float[ndarray, "rows joints"]:
    """The least weight of all repetitions at the same phase, none where one of them lacks a row.

    What differs between repetitions is a column less its mean over them: only where all count
    alike is it blind to what the model lacks in each of them.
    """
    if recording.period is None:
        return weights
    period = recording.period * recording.band.rate
    # Two rows: where repetitions are no multiple of a row, one may lie beside the other.
    width = 2 * recording.band.factor
    fine = np.arange(len(recording.motion))
    rows = recording.samples
    turn = np.floor((fine + 0.5) / period).astype(int)
    place = recording.place_in_period // width
    bins = (turn.max() + 1, place.max() + 1)
    least = np.full((*bins, weights.shape[1]), np.inf)
    np.minimum.at(least, (turn[rows], place[rows]), weights)
    seen = np.zeros(bins, dtype=bool)
    seen[turn, place] = True
    least = np.where(np.isinf(least), 0.0, least)
    common = np.where(seen[:, :, None], least, np.inf).min(axis=0)
    return np.minimum(weights, common[place[rows]])


def _stretches(inside: Bool[ndarray, " rows"]) -> Float[ndarray, " rows"]:
    """Rows of the stretch that each row is inside of, one for rows that are in none."""
    edges = np.flatnonzero(np.diff(inside)) + 1
    lengths = np.diff(edges, prepend=0, append=len(inside))
    return np.where(inside, np.repeat(lengths, lengths), 1.0)


def _weights_of(
    recording: Prepared, joint: int, noise: Autoregression, coulomb: float
) -> Float[ndarray, " rows"]:
    spread = direction_error(recording, joint, coulomb)[:: recording.band.factor]
    # At rest friction stays as it is: all rows of a stop tell no more than one.
    resting = recording.band.apply(stopped(recording, joint) * 1.0) > HALF
    spread = spread * np.sqrt(_stretches(resting))
    error = np.abs(noise.whiten(spread[:, None])[:, 0])
    error = maximum_filter1d(np.maximum(error, spread / noise.deviation), 3)
    weights = 1 / np.sqrt(1 + error**2)
    # A row is as good as the past that whitening reads.
    lacking = np.convolve(~recording.valid, np.ones(noise.order + 1))[: len(weights)]
    weights[lacking > 0.5] = 0.0
    weights[: noise.order] = 0.0
    return weights
