"""Errors of several models on the same sealed rows, with intervals by blocks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.inference.errors import Predictor
from oed.diagnosis.numbers import BLOCK_SECONDS, REPLICATES
from oed.experiment.preparation.prepared import Prepared
from studies.public_arms.arm import Torque

INTERVAL = (2.5, 97.5)  # [%]


@dataclass(frozen=True)
class SealedErrors:
    """What each model leaves on the sealed rows, all rows counting alike.

    Attributes:
        rms: (n,) of each model's error, by name [N m].
        torque: (n,) rms torque [N m].
        relative: Rms error over rms torque, all joints together, by name.
        interval: Its 95 % interval, by name.
        ratio: By name, the 95 % interval of the loop's rms over that model's, from the same blocks.
    """

    rms: Mapping[str, Float[ndarray, " joints"]]
    torque: Float[ndarray, " joints"]
    relative: Mapping[str, float]
    interval: Mapping[str, tuple[float, float]]
    ratio: Mapping[str, tuple[float, float]]


def of_predictor(predictor: Predictor, rows: Prepared) -> Float[ndarray, "valid_rows joints"]:
    """Measured less predicted torque of a model of ours [N m]."""
    return predictor.errors(rows)


def of_torque(torque: Torque, rows: Prepared) -> Float[ndarray, "valid_rows joints"]:
    """The same of a published model, in the same band."""
    return (rows.torque - rows.band.apply(torque(rows.motion)))[rows.valid]


def compare(
    errors: Mapping[str, Sequence[Float[ndarray, "_ joints"]]],
    rows: Sequence[Prepared],
    rng: np.random.Generator,
    *,
    ours: str,
) -> SealedErrors:
    """Put models side by side.

    Args:
        errors: By model, one array a recording.
        rows: The sealed recordings.
        rng: Draws blocks.
        ours: The model that the others are compared with.
    """
    length = max(1, round(BLOCK_SECONDS * rows[0].band.analysis_rate))
    torque = [p.torque[p.valid] for p in rows]
    blocks = {name: _blocks(each, length) for name, each in errors.items()}
    power = _blocks(torque, length)
    draws = rng.integers(0, len(power), (REPLICATES, len(power)))
    drawn = {name: each[draws].sum(axis=(1, 2)) for name, each in blocks.items()}
    moved = power[draws].sum(axis=(1, 2))
    count = sum(map(len, torque))

    def ends(values: Float[ndarray, " draws"]) -> tuple[float, float]:
        low, high = np.percentile(np.sqrt(values), INTERVAL)
        return float(low), float(high)

    return SealedErrors(
        {name: np.sqrt(each.sum(axis=0) / count) for name, each in blocks.items()},
        np.sqrt(power.sum(axis=0) / count),
        {name: float(np.sqrt(each.sum() / power.sum())) for name, each in blocks.items()},
        {name: ends(each / moved) for name, each in drawn.items()},
        {name: ends(drawn[ours] / each) for name, each in drawn.items() if name != ours},
    )


def _blocks(
    series: Sequence[Float[ndarray, "_ joints"]], length: int
) -> Float[ndarray, "blocks joints"]:
    sums = [np.add.reduceat(x**2, np.arange(0, len(x), length), axis=0) for x in series]
    return np.concatenate(sums)
