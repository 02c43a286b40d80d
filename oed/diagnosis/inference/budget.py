"""The torque budget: what each term carries of each joint's torque, and what is left."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.inference.errors import Predictor
from oed.dynamics.effects.effect import Effect, with_columns
from oed.experiment.preparation.prepared import Prepared


@dataclass(frozen=True)
class Share:
    """What one term carries.

    Attributes:
        label: In words.
        rms: (n,) root mean square of its torque at each joint, in the analysis band [N m].
    """

    label: str
    rms: Float[ndarray, " joints"]


@dataclass(frozen=True)
class Budget:
    """Where each joint's torque goes on some recordings.

    Attributes:
        role: Of the recordings: held out where there are such.
        shares: Of each term; parts of the base model first.
        left: (n,) rms of what is left [N m].
        floor: (n,) deviation of the noise [N m].
    """

    role: str
    shares: tuple[Share, ...]
    left: Float[ndarray, " joints"]
    floor: Float[ndarray, " joints"]


def budget(
    role: str,
    prepared: Sequence[Prepared],
    weights: Sequence[Float[ndarray, "_ joints"]],
    after: Predictor,
    *,
    labels: Sequence[tuple[str, Predictor]],
    floor: Float[ndarray, " joints"],
    base: int,
) -> Budget:
    """Take a prediction apart.

    Args:
        role: Of the recordings.
        prepared: The recordings.
        weights: Of their valid rows.
        after: The whole model.
        labels: Label of each addition, and the whole model without it.
        floor: (n,) [N m].
        base: Effects of the base model, the first of the whole one.
    """
    total = [after.torque(p) for p in prepared]
    shares = [
        Share(name, _rms([part.torque(p)[p.valid] for p in prepared], weights))
        for name, part in _base_parts(after, base)
    ]
    for label, rest in labels:
        change = [(t - rest.torque(p))[p.valid] for t, p in zip(total, prepared, strict=True)]
        shares.append(Share(label, _rms(change, weights)))
    left = [(p.torque - t)[p.valid] for t, p in zip(total, prepared, strict=True)]
    return Budget(role, tuple(shares), _rms(left, weights), floor)


def _base_parts(after: Predictor, base: int) -> list[tuple[str, Predictor]]:
    """Effects of the base model, those of one name together, each kind alone."""
    found: dict[str, list[tuple[Effect, slice]]] = {}
    for effect, place in list(with_columns(after.model.effects))[:base]:
        found.setdefault(effect.name, []).append((effect, place))
    parts = []
    for name, own in found.items():
        values = np.concatenate([after.parameters[place] for _, place in own])
        alone = dataclasses.replace(
            after.model, effects=tuple(effect for effect, _ in own), measurement=()
        )
        parts.append((name.replace("_", " "), Predictor(alone, values)))
    return parts


def _rms(
    series: Sequence[Float[ndarray, "_ joints"]], weights: Sequence[Float[ndarray, "_ joints"]]
) -> Float[ndarray, " joints"]:
    mass = np.sum([w.sum(axis=0) for w in weights], axis=0)
    squares = np.sum([(x**2 * w).sum(axis=0) for x, w in zip(series, weights, strict=True)], axis=0)
    return np.sqrt(squares / np.maximum(mass, 1e-300))
