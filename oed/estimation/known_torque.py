"""Torque that is known before an estimate, and taken off the measured one."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import Effect
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepared import Prepared


@dataclass(frozen=True)
class KnownTorque:
    """Effects with numbers, which an estimate leaves as they are.

    Attributes:
        effects: Whose torque is known.
        parameters: (k,) of all their columns.
    """

    effects: tuple[Effect, ...] = ()
    parameters: Float[ndarray, " k"] = dataclasses.field(default_factory=lambda: np.zeros(0))

    def taken_off(self, recordings: Sequence[Prepared], model: TorqueModel) -> tuple[Prepared, ...]:
        """Recordings without that torque, in their own band and through the model's measurement."""
        if not self.effects:
            return tuple(recordings)
        own = dataclasses.replace(model, effects=self.effects)
        left = [r.fine_torque - own.torque(self.parameters, r.motion) for r in recordings]
        return tuple(
            dataclasses.replace(r, fine_torque=fine, torque=r.band.apply(fine))
            for r, fine in zip(recordings, left, strict=True)
        )
