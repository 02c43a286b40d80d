"""Errors before and after on every kind of recording, with block-bootstrap intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.tables.predict import rms
from oed.experiment.preparation.band import BLOCK

INTERVAL = (2.5, 97.5)  # [%]


@dataclass(frozen=True)
class RoleProof:
    """Errors on the recordings of one role, joint by joint.

    All are weighted by the share of noise in the variance of a row: where the direction of motion
    is uncertain, dry friction makes the rows uncertain for every model.

    Attributes:
        role: "estimation", "validation" or "test".
        counted: (n,) share of the rows that the weights leave.
        before: (n,) rms of the base model's error [N m].
        after: (n,) rms with the additions [N m].
        torque: (n,) rms of the torque on these rows [N m].
        before_interval: (n, 2) 95 % block-bootstrap interval [N m].
        after_interval: (n, 2) the same after [N m].
        change_interval: (n, 2) of after less before, from the same blocks [N m].
    """

    role: str
    counted: Float[ndarray, " joints"]
    before: Float[ndarray, " joints"]
    after: Float[ndarray, " joints"]
    torque: Float[ndarray, " joints"]
    before_interval: Float[ndarray, "joints 2"]
    after_interval: Float[ndarray, "joints 2"]
    change_interval: Float[ndarray, "joints 2"]


def prove(
    role: str,
    before: Sequence[Float[ndarray, "_ joints"]],
    after: Sequence[Float[ndarray, "_ joints"]],
    torque: Sequence[Float[ndarray, "_ joints"]],
    weights: Sequence[Float[ndarray, "_ joints"]],
    *,
    rate: float,
    replicates: int,
    rng: np.random.Generator,
) -> RoleProof:
    """Errors before and after with intervals; blocks of both are drawn together.

    Args:
        role: Of the recordings.
        before: Errors of the base model, one array a recording [N m].
        after: Errors with the additions [N m].
        torque: Measured torque [N m].
        weights: Of the rows, from 0 to 1.
        rate: Rows a second [Hz].
        replicates: Of the bootstrap.
        rng: Draws blocks.
    """
    old, new = (
        _block_sums([e * w for e, w in zip(x, weights, strict=True)], rate) for x in (before, after)
    )
    mass = _block_sums(weights, rate)
    draws = rng.integers(0, len(mass), (replicates, len(mass)))
    counts = mass[draws].sum(axis=1)
    old_rms = np.sqrt(old[draws].sum(axis=1) / counts)
    new_rms = np.sqrt(new[draws].sum(axis=1) / counts)
    return RoleProof(
        role=role,
        counted=mass.sum(axis=0) / sum(len(w) for w in weights),
        before=np.sqrt(old.sum(axis=0) / mass.sum(axis=0)),
        after=np.sqrt(new.sum(axis=0) / mass.sum(axis=0)),
        torque=rms(torque, weights),
        before_interval=np.percentile(old_rms, INTERVAL, axis=0).T,
        after_interval=np.percentile(new_rms, INTERVAL, axis=0).T,
        change_interval=np.percentile(new_rms - old_rms, INTERVAL, axis=0).T,
    )


def error_in_floors(
    proofs: Sequence[RoleProof], floor: Float[ndarray, " joints"], role: str
) -> Float[ndarray, " joints"]:
    """Error after on the recordings of a role, in noise floors; zero without them."""
    found = [p.after / floor for p in proofs if p.role == role]
    return found[0] if found else np.zeros(len(floor))


def _block_sums(
    series: Sequence[Float[ndarray, "_ joints"]], rate: float
) -> Float[ndarray, "blocks joints"]:
    """Sums of squares of blocks of `BLOCK` seconds, which are drawn together."""
    length = max(1, round(BLOCK * rate))
    return np.concatenate(
        [np.add.reduceat(x**2, np.arange(0, len(x), length), axis=0) for x in series]
    )
