"""What uncertain directions of motion hide of white rows.

Where a joint turns, dry friction is anywhere between its two values: noise of its own, large,
and alike within a stretch. Whitened, each stretch is one column; beside noise of unit variance the
covariance of all rows is the identity plus the squares of these columns. Its inverse root takes
out of the rows just what they hide, however far whitening has spread it (Rao 1973, "Linear
Statistical Inference and its Applications", section 4a).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.estimation.noise_floor.autoregression import Autoregression
from oed.experiment.preparation.direction import hardly_moves, uncertain_direction
from oed.experiment.preparation.prepared import Prepared

# Pieces to a period of the band's edge, within which friction is alike while a joint turns: it
# changes as fast as the band shows.
PIECES = 8
AT_ONCE = 500  # rows
NOTHING = 1e-3  # share of a direction, below which nothing of it is lost


@dataclass(frozen=True)
class _Part:
    """Directions of some white rows that tell less than others.

    Attributes:
        rows: Which rows.
        directions: (R, k) orthonormal.
        shares: (k,) by which each is shortened, 0 to 1.
    """

    rows: slice
    directions: Float[ndarray, "rows k"]
    shares: Float[ndarray, " k"]


@dataclass(frozen=True)
class UncertainSign:
    """What one joint's white rows of one recording do not tell.

    Attributes:
        parts: One after another, so that a long recording costs no more than it is longer.
    """

    parts: tuple[_Part, ...]

    def out_of(self, white: Float[ndarray, "rows columns"]) -> Float[ndarray, "rows columns"]:
        """White rows without it."""
        result = white.copy()
        for part in self.parts:
            inside = part.directions.T @ white[part.rows]
            result[part.rows] -= part.directions @ (part.shares[:, None] * inside)
        return result

    @property
    def count(self) -> float:
        """Rows that it costs."""
        return float(sum(np.sum(1 - (1 - part.shares) ** 2) for part in self.parts))


def uncertain_in(
    recording: Prepared, joint: int, noise: Autoregression, coulomb: float
) -> tuple[UncertainSign, Float[ndarray, " rows"]]:
    """What a joint's turns and stops hide, and the rows that have their past.

    Args:
        recording: One run, or a mean of repetitions.
        joint: Index.
        noise: Of its rows.
        coulomb: Height of the friction step, one side [N m].
    """
    band, rows = recording.band, recording.rows
    whole = np.ones(rows)
    lacking = np.convolve(~recording.valid, np.ones(noise.order + 1))[:rows]
    whole[lacking > 0.5] = 0.0
    whole[: noise.order] = 0.0
    # Smoothing rounds off the kinks where a joint stops and breaks loose.
    doubtful = uncertain_direction(recording, joint) | hardly_moves(recording, joint)
    length = max(1, round(band.rate / (PIECES * band.cutoff)))
    parts = []
    for first in range(0, rows, AT_ONCE):
        own = slice(first, min(first + AT_ONCE, rows))
        past = max(first - noise.order, 0)
        seen = slice(past * band.factor, (own.stop - 1) * band.factor + len(band.taps))
        friction = _stretches(doubtful[seen], length) * (abs(coulomb) / np.sqrt(3))
        columns = noise.whiten(band.apply(friction))[first - past :] * whole[own, None]
        directions, lengths, _ = np.linalg.svd(columns, full_matrices=False)
        shares = 1 - 1 / np.sqrt(1 + lengths**2)
        kept = shares > NOTHING
        parts.append(_Part(own, directions[:, kept], shares[kept]))
    return UncertainSign(tuple(parts)), whole


def _stretches(
    doubtful: Bool[ndarray, " samples"], length: int
) -> Float[ndarray, "samples stretches"]:
    """One column of zeros and ones for each stretch within which friction is alike.

    As many as the band can tell apart: where a joint sticks, friction follows what pushes it.
    """
    edges = np.flatnonzero(np.diff(doubtful, prepend=False, append=False)).tolist()
    stretches = [
        range(k, min(k + length, end))
        for start, end in zip(edges[::2], edges[1::2], strict=True)
        for k in range(start, end, length)
    ]
    result = np.zeros((len(doubtful), len(stretches)))
    for column, stretch in enumerate(stretches):
        result[stretch, column] = 1.0
    return result
