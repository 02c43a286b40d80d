"""Torque that is known before an estimate, and taken off the measured one."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import Effect
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.processing import ProcessedRecording
from oed.experiment.recording import Role

Recordings = dict[Role, tuple[ProcessedRecording, ...]]


@dataclass(frozen=True)
class KnownTorque:
    """Effects with numbers, which an estimate leaves as they are.

    Attributes:
        effects: Whose torque is known.
        parameters: (k,) of all their columns.
    """

    effects: tuple[Effect, ...] = ()
    parameters: Float[ndarray, " k"] = dataclasses.field(default_factory=lambda: np.zeros(0))

    def taken_off(self, recordings: Recordings, model: TorqueModel) -> Recordings:
        """Recordings without that torque, in their own band and through the model's measurement."""
        if not self.effects:
            return recordings
        own = dataclasses.replace(model, effects=self.effects)
        return {
            role: tuple(
                dataclasses.replace(r, tau=r.tau - r.columns(own.columns) @ self.parameters)
                for r in of_role
            )
            for role, of_role in recordings.items()
        }
