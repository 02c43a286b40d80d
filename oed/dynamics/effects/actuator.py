"""A wrong gain between the torque of a joint and what is recorded as such."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.effect import Effect, MeasurementEffect, Parameter, State
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.motion import Motion
from oed.dynamics.scalars import Scalar


@dataclass(frozen=True)
class GainError(Effect):
    """epsilon (H theta)_j: a torque scaled by 1 + epsilon, to first order exact in epsilon.

    Only parameters that joint j shares with others tell it from a change of parameters
    (Gautier and Briot 2014 therefore identify all gains with a known payload).

    Attributes:
        joint: Index of the joint.
        reference: Gives H theta.
    """

    joint: int
    reference: ReferenceTorque
    name = "torque_gain"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The relative error epsilon."""
        return (Parameter(f"gain_error_{self.joint + 1}", "1", self.joint),)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's torque."""
        return (f"tau_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """(H theta)_j."""
        return [{self.joint: self.reference.total(state)[self.joint]}]


@dataclass(frozen=True)
class TorqueGain(MeasurementEffect):
    """The recorded torque of one joint is `gain` times the true one."""

    joint: int
    gain: float
    name = "torque_gain"

    def through(
        self,
        columns: Callable[[Motion], Float[ndarray, "samples joints columns"]],
        motion: Motion,
    ) -> Float[ndarray, "samples joints columns"]:
        """The columns with the joint's row scaled."""
        result = np.array(columns(motion))
        result[:, self.joint] *= self.gain
        return result
