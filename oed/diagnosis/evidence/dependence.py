"""Where a residual lives: partial dependence on each coordinate, colour, and reversals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.signal import welch

from oed.experiment.preparation.band import BLOCK
from oed.experiment.preparation.prepared import Prepared

BINS = 24
OF_ITS_OWN = ("ddq", "temperature")  # that say something of their own joint alone


@dataclass(frozen=True)
class Dependence:
    """Mean residual of one joint over one coordinate.

    Attributes:
        joint: Whose residual.
        coordinate: Such as "dq_1", "temperature_1" or "time".
        centre: (B,) middle of each bin.
        mean: (B,) mean residual there [N m].
        deviation: (B,) standard error of the mean, from the scatter between blocks [N m].
        share: Of the residual's variance that the means carry.
    """

    joint: int
    coordinate: str
    centre: Float[ndarray, " bins"]
    mean: Float[ndarray, " bins"]
    deviation: Float[ndarray, " bins"]
    share: float


@dataclass(frozen=True)
class Spectrum:
    """Power density of the residuals before and after [N^2 m^2/Hz].

    Attributes:
        frequency: (F,) [Hz].
        before: (F, n).
        after: (F, n).
    """

    frequency: Float[ndarray, " frequencies"]
    before: Float[ndarray, "frequencies joints"]
    after: Float[ndarray, "frequencies joints"]


def dependences(
    prepared: Sequence[Prepared], errors: Sequence[Float[ndarray, "_ joints"]]
) -> tuple[Dependence, ...]:
    """Every joint's residual over all positions and velocities, its acceleration and warmth, time.

    All in the analysis band: what encoders add to an acceleration above it would hide the motion.
    """
    joints = errors[0].shape[1]
    coordinates = coordinates_of(prepared)
    stacked = np.concatenate(list(errors))
    blocks = blocks_of(prepared)
    return tuple(
        binned(j, name, x, stacked[:, j], blocks)
        for j in range(joints)
        for name, x in coordinates.items()
        if not name.startswith(OF_ITS_OWN) or name.endswith(f"_{j + 1}")
    )


def coordinates_of(prepared: Sequence[Prepared]) -> dict[str, Float[ndarray, " rows"]]:
    """Every joint's position, velocity, acceleration and temperature in the band, and time."""
    found, kinds = {}, ["q", "dq", "ddq"]
    if all(p.motion.temperature is not None for p in prepared):
        kinds.append("temperature")
    for kind in kinds:
        values = np.concatenate([p.band.apply(getattr(p.motion, kind))[p.valid] for p in prepared])
        found |= {f"{kind}_{j + 1}": values[:, j] for j in range(values.shape[1])}
    return found | {"time": np.concatenate([p.t[p.valid] for p in prepared])}


def blocks_of(prepared: Sequence[Prepared]) -> Int[ndarray, " rows"]:
    """Number of the block of `BLOCK` seconds of each valid row: one observation each."""
    parts, offset = [], 0
    for p in prepared:
        length = max(1, round(BLOCK * p.band.analysis_rate))
        own = np.arange(int(p.valid.sum())) // length
        parts.append(own + offset)
        offset += int(own[-1]) + 1
    return np.concatenate(parts)


def binned(
    joint: int,
    name: str,
    x: Float[ndarray, " rows"],
    y: Float[ndarray, " rows"],
    blocks: Int[ndarray, " rows"],
) -> Dependence:
    """Means of a joint's residual in bins of as many rows each.

    Args:
        joint: Index.
        name: Of the coordinate.
        x: Its values.
        y: The residual [N m].
        blocks: Number of the block of each row.
    """
    edges = np.unique(np.quantile(x, np.linspace(0, 1, BINS + 1)))
    place = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, max(len(edges) - 2, 0))
    centre, mean, deviation = [], [], []
    for k in range(max(len(edges) - 1, 1)):
        inside = place == k
        if inside.sum() < 3:
            continue
        own = blocks[inside]
        sums = np.bincount(own, weights=y[inside])
        counts = np.bincount(own)
        centre.append(float(x[inside].mean()))
        average = float(y[inside].mean())
        mean.append(average)
        # Rows of one block are one observation: the scatter of block sums is the honest one.
        seen = counts > 0
        scatter = float(np.sum((sums[seen] - counts[seen] * average) ** 2))
        deviation.append(np.sqrt(scatter) / counts.sum())
    average = np.array(mean)
    weights = np.full(len(average), 1 / max(len(average), 1))
    total = float(np.var(y))
    spread = float(np.sum(weights * (average - average.mean()) ** 2)) if len(average) else 0.0
    share = spread / total if total > 0 else 0.0
    return Dependence(joint, name, np.array(centre), average, np.array(deviation), min(share, 1.0))


def spectrum(
    before: Sequence[Float[ndarray, "_ joints"]],
    after: Sequence[Float[ndarray, "_ joints"]],
    rate: float,
) -> Spectrum:
    """Power density of residuals, averaged over recordings (Welch)."""
    length = int(min(256, *(len(e) for e in before)))
    frequency, _ = welch(before[0][:, 0], fs=rate, nperseg=length)
    old, new = (
        np.mean([welch(e, fs=rate, nperseg=length, axis=0)[1] for e in errors], axis=0)
        for errors in (before, after)
    )
    return Spectrum(frequency, old, new)
