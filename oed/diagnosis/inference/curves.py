"""What each addition gives over the coordinate on which it depends most, and what is missing without it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.inference.errors import Predictor
from oed.experiment.preparation.prepared import Prepared

BINS = 24  # of a coordinate, with as many rows each
KINDS = ("q", "dq", "ddq")


@dataclass(frozen=True)
class Curve:
    """One addition at the joint where it gives most.

    Attributes:
        label: Of the addition.
        joint: From 0.
        coordinate: Such as "dq_2" (joints from 1), or "time".
        is_along: Whether torque is counted in the direction in which the joint moves, as friction is.
        centre: (B,) mean of the coordinate in each bin, in its SI unit.
        given: (B,) mean of what the addition gives there [N m].
        missing: (B,) mean of what is left without it [N m].
        error: (B,) standard error of that, blocks of a bin taken for independent [N m].
    """

    label: str
    joint: int
    coordinate: str
    is_along: bool
    centre: Float[ndarray, " bins"]
    given: Float[ndarray, " bins"]
    missing: Float[ndarray, " bins"]
    error: Float[ndarray, " bins"]


def curve(
    label: str,
    prepared: Sequence[Prepared],
    *,
    after: Predictor,
    rest: Predictor,
    coordinates: Sequence[str],
    floor: Float[ndarray, " joints"],
) -> Curve | None:
    """An addition over the one of its coordinates that tells most of it; None where it has none.

    What turns with the joint's direction, such as friction that varies with position, is counted in
    that direction: over position it would cancel.

    Args:
        label: Of the addition.
        prepared: Recordings to show it on.
        after: The whole model.
        rest: The same without the addition.
        coordinates: On which it depends, such as "q_1".
        floor: (n,) deviation of the noise [N m].
    """
    without = [rest.torque(p) for p in prepared]
    given = _valid(prepared, [after.torque(p) - w for p, w in zip(prepared, without, strict=True)])
    missing = _valid(prepared, [p.torque - w for p, w in zip(prepared, without, strict=True)])
    joint = int(np.argmax(np.sqrt(np.mean(given**2, axis=0)) / floor))
    shown = [name for name in coordinates if name == "time" or name.rpartition("_")[0] in KINDS]
    if not shown or len(given) < BINS:
        return None
    own, left, velocity = given[:, joint], missing[:, joint], f"dq_{joint + 1}"
    ways = [(name, False) for name in shown]
    if velocity in shown:
        ways += [(name, True) for name in shown if name != velocity]
    sign = np.sign(_values(prepared, velocity))
    best, most = None, -np.inf
    for name, is_along in ways:
        centre, place = _bins(_values(prepared, name))
        factor = sign if is_along else 1.0
        told = float(np.mean(_means(factor * own, place) ** 2))
        if told > most:
            best, most = (name, is_along, centre, place, factor), told
    if best is None:
        return None
    name, is_along, centre, place, factor = best
    left = factor * left
    spread = np.sqrt(np.maximum(_means(left**2, place) - _means(left, place) ** 2, 0.0))
    error = spread / np.sqrt(np.bincount(place, minlength=BINS))
    means = _means(factor * own, place), _means(left, place)
    return Curve(label, joint, name, is_along, centre, *means, error)


def _valid(
    prepared: Sequence[Prepared], series: Sequence[Float[ndarray, "_ joints"]]
) -> Float[ndarray, "rows joints"]:
    return np.concatenate([x[p.valid] for p, x in zip(prepared, series, strict=True)])


def _values(prepared: Sequence[Prepared], name: str) -> Float[ndarray, " rows"]:
    if name == "time":
        return np.concatenate([p.t[p.valid] for p in prepared])
    kind, _, joint = name.rpartition("_")
    fine = [getattr(p.motion, kind)[:, int(joint) - 1] for p in prepared]
    pairs = zip(prepared, fine, strict=True)
    return np.concatenate([p.band.instants(x)[p.valid] for p, x in pairs])


def _bins(values: Float[ndarray, " rows"]) -> tuple[Float[ndarray, " bins"], ndarray]:
    """Mean of each bin, and the bin of each row."""
    place = np.empty(len(values), dtype=int)
    place[np.argsort(values, kind="stable")] = np.arange(len(values)) * BINS // len(values)
    return _means(values, place), place


def _means(values: Float[ndarray, " rows"], place: ndarray) -> Float[ndarray, " bins"]:
    return np.bincount(place, weights=values, minlength=BINS) / np.bincount(place, minlength=BINS)
