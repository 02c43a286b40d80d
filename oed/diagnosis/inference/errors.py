"""Errors before and after on every kind of recording, with block-bootstrap intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.evidence.columns import pieces
from oed.diagnosis.numbers import BLOCK_SECONDS, REPLICATES
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepared import Prepared

INTERVAL = (2.5, 97.5)  # [%]


@dataclass(frozen=True)
class Predictor:
    """An ordinary torque model with numbers for its parameters.

    Attributes:
        model: With all effects in their exact form.
        parameters: (p,) of all its columns, regrouped ones at zero.
    """

    model: TorqueModel
    parameters: Float[ndarray, " parameters"]

    def torque(self, prepared: Prepared) -> Float[ndarray, "rows joints"]:
        """Predicted torque in the analysis band [N m], a piece of the recording after another."""
        if any(effect.beyond_state for effect in self.model.effects) or len(prepared.motion) < LONG:
            return prepared.band.apply(self.model.torque(self.parameters, prepared.motion))
        result = np.empty((prepared.rows, self.model.robot.n))
        for rows, fine, skipped in pieces(prepared, remembers=True):
            own = prepared.band.apply(self.model.torque(self.parameters, prepared.motion[fine]))
            result[rows] = own[skipped : skipped + rows.stop - rows.start]
        return result

    def errors(self, prepared: Prepared) -> Float[ndarray, "valid_rows joints"]:
        """Measured less predicted torque of the rows that are valid [N m]."""
        return (prepared.torque - self.torque(prepared))[prepared.valid]


LONG = 60_000  # fine samples from which on a recording is predicted piece by piece


@dataclass(frozen=True)
class RoleErrors:
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


def compare(
    role: str,
    prepared: Sequence[Prepared],
    weights: Sequence[Float[ndarray, "_ joints"]],
    *,
    before: Predictor,
    after: Predictor,
    rng: np.random.Generator,
) -> RoleErrors:
    """Errors of two models on some recordings; blocks of both are drawn together.

    Args:
        role: Of the recordings.
        prepared: The recordings.
        weights: Of their valid rows, from 0 to 1.
        before: The base model.
        after: With what was found.
        rng: Draws blocks.
    """
    length = max(1, round(BLOCK_SECONDS * prepared[0].band.analysis_rate))

    def sums(series: Sequence[Float[ndarray, "_ joints"]]) -> Float[ndarray, "blocks joints"]:
        return np.concatenate(
            [np.add.reduceat(x, np.arange(0, len(x), length), axis=0) for x in series]
        )

    old, new, torque = (
        sums([e**2 * w for e, w in zip(errors, weights, strict=True)])
        for errors in (
            [before.errors(p) for p in prepared],
            [after.errors(p) for p in prepared],
            [p.torque[p.valid] for p in prepared],
        )
    )
    mass = sums(weights)
    draws = rng.integers(0, len(mass), (REPLICATES, len(mass)))
    counts = mass[draws].sum(axis=1)
    old_rms, new_rms = (np.sqrt(x[draws].sum(axis=1) / counts) for x in (old, new))

    def whole(x: Float[ndarray, "blocks joints"]) -> Float[ndarray, " joints"]:
        return np.sqrt(x.sum(axis=0) / np.maximum(mass.sum(axis=0), 1e-300))

    return RoleErrors(
        role,
        mass.sum(axis=0) / sum(len(w) for w in weights),
        whole(old),
        whole(new),
        whole(torque),
        np.percentile(old_rms, INTERVAL, axis=0).T,
        np.percentile(new_rms, INTERVAL, axis=0).T,
        np.percentile(new_rms - old_rms, INTERVAL, axis=0).T,
    )
