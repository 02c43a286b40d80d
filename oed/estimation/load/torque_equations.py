"""The torque equations of a loaded arm, linear about an estimate.

With the signs of r and of the velocity kept, r times its own friction is linear in beta, phi and, at a
given mu, in mu: the steps of Gauss and Newton are small least-squares problems, and what comes out at
the end has the covariance of the whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.load.loaded_model import LoadedModel
from oed.experiment.preparation.processed import ProcessedRecording


@dataclass(frozen=True)
class TorqueEquations:
    """Recordings of one arm in one state, ready to be linearised.

    Attributes:
        model: Of the arm and its load.
        recordings: At least one, each processed.
        columns: (fine, n, c) of each recording, before the low-pass.
        signs: (fine, n) of each recording.
    """

    model: LoadedModel
    recordings: tuple[ProcessedRecording, ...]
    columns: tuple[Float[ndarray, "_ joints columns"], ...]
    signs: tuple[Float[ndarray, "_ joints"], ...]

    @classmethod
    def of(cls, model: LoadedModel, recordings: Sequence[ProcessedRecording]) -> TorqueEquations:
        """Evaluate a model along recordings."""
        return cls(
            model,
            tuple(recordings),
            tuple(model.raw_columns(recording.fine) for recording in recordings),
            tuple(model.signs(recording.fine) for recording in recordings),
        )

    @property
    def torque(self) -> Float[ndarray, "samples joints"]:
        """Measured, one recording after another [N m]."""
        return np.concatenate([recording.tau for recording in self.recordings])

    @property
    def segments(self) -> tuple[int, ...]:
        """Samples of each recording."""
        return tuple(len(recording) for recording in self.recordings)

    def linearised(
        self, at: Float[ndarray, " x"]
    ) -> tuple[Float[ndarray, "rows x"], Float[ndarray, "samples joints"]]:
        """Regressor and torque of the linear problem about an estimate, in the band of the torque.

        The solution of these equations is the next estimate, not its step.
        """
        pieces = [self._linearised(*given, at) for given in self._given]
        rows = np.concatenate([rows for rows, _ in pieces])
        shift = np.concatenate([shift for _, shift in pieces])
        return rows.reshape(-1, rows.shape[2]), self.torque + shift

    def modelled(self, at: Float[ndarray, " x"]) -> Float[ndarray, "samples joints"]:
        """Torque of an estimate, in the band of what was measured [N m]."""
        pieces = []
        for recording, columns, signs in self._given:
            torque = columns @ at[: columns.shape[2]]
            if self.model.has_load_friction:
                rigid = self.model.is_rigid
                pressing = columns[:, :, rigid] @ at[: columns.shape[2]][rigid]
                torque = torque + at[self.model.load_friction] * np.abs(pressing) * signs
            pieces.append(_in_band(recording, torque[:, :, None])[:, :, 0])
        return np.concatenate(pieces)

    @property
    def _given(self) -> list[tuple[ProcessedRecording, ndarray, ndarray]]:
        return list(zip(self.recordings, self.columns, self.signs, strict=True))

    def _linearised(
        self,
        recording: ProcessedRecording,
        columns: Float[ndarray, "fine joints columns"],
        signs: Float[ndarray, "fine joints"],
        at: Float[ndarray, " x"],
    ) -> tuple[Float[ndarray, "samples joints x"], Float[ndarray, "samples joints"]]:
        model = self.model
        if not model.has_load_friction:
            return _in_band(recording, columns), np.zeros_like(recording.tau)
        rigid, mu = model.is_rigid, at[model.load_friction]
        pressing = columns[:, :, rigid] @ at[: columns.shape[2]][rigid]
        growth = 1 + mu * np.sign(pressing) * signs
        bent = columns.copy()
        bent[:, :, rigid] *= growth[:, :, None]
        friction = np.abs(pressing) * signs
        own = friction[:, :, None] * np.eye(len(mu))
        rows = _in_band(recording, np.concatenate([bent, own], axis=2))
        # r times its friction stands twice in these rows, once by beta and phi and once by mu.
        return rows, rows[:, :, -len(mu) :] @ mu


def _in_band(
    recording: ProcessedRecording, columns: Float[ndarray, "fine joints columns"]
) -> Float[ndarray, "samples joints columns"]:
    return recording.columns(lambda _: columns)
