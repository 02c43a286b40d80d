"""A wrong gain between the torque of a joint and what is recorded as such."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.effects.effect import Parameter, State
from oed.dynamics.effects.measurement_effect import Instants, MeasurementEffect
from oed.dynamics.effects.on_reference import FollowsTorque
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.motion import Motion
from oed.dynamics.scalars import Scalar, magnitude, mul, sign


@dataclass(frozen=True)
class GainError(FollowsTorque):
    """epsilon (H theta)_j: a torque scaled by 1 + epsilon, to first order exact in epsilon.

    Only parameters that joint j shares with others tell it from a change of parameters
    (Gautier and Briot 2014 therefore identify all gains with a known payload). An amplifier of two
    halves may have a gain for each sign: 1 + epsilon + delta for positive torque, 1 + epsilon -
    delta for negative.

    Attributes:
        joint: Index of the joint.
        reference: Gives H theta.
        by_sign: Whether delta is a parameter.
    """

    joint: int
    reference: ReferenceTorque
    by_sign: bool = False
    name = "torque_gain"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The relative error epsilon, and delta."""
        names = ("gain_error", "gain_by_sign") if self.by_sign else ("gain_error",)
        return tuple(Parameter(f"{name}_{self.joint + 1}", "1", self.joint) for name in names)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's torque."""
        return (f"tau_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """(H theta)_j, and its size."""
        torque = self.reference.total(state)[self.joint]
        return [{self.joint: torque}, {self.joint: magnitude(torque)}][: len(self.parameters)]


@dataclass(frozen=True)
class TorqueGain(MeasurementEffect):
    """The recorded torque of one joint is `gain` times the true one.

    Attributes:
        joint: Index of the joint.
        gain: Of the torque.
        by_sign: What that of positive torque has more, and that of negative less.
        reference: Tells the sign.
    """

    joint: int
    gain: float
    by_sign: float
    reference: ReferenceTorque
    name = "torque_gain"

    def through(
        self,
        columns: Callable[[Motion], Float[ndarray, "samples joints columns"]],
        motion: Motion,
        rigid: Bool[ndarray, " columns"],  # noqa: ARG002  # all columns alike
    ) -> Float[ndarray, "samples joints columns"]:
        """The columns with the joint's row scaled."""
        result = np.array(columns(motion))
        result[:, self.joint] *= self._gain(motion)[:, None]
        return result

    def undone(
        self,
        t: Float[ndarray, " samples"],  # noqa: ARG002  # a gain is the same at all times
        tau: Float[ndarray, "samples joints"],
    ) -> Float[ndarray, "samples joints"]:
        """The joint's torque divided by the gain of its sign."""
        own = tau[:, self.joint]
        result = tau.copy()
        result[:, self.joint] = own / (self.gain + self.by_sign * np.sign(own))
        return result

    def after(self, inner: Instants, joints: int, step: float) -> Instants:  # noqa: ARG002
        """The joint's torque scaled; the sign is that of the torque as modelled."""
        own = self.reference
        remembered = len(own.keeps) if self.by_sign != 0 else 0

        def begin(state: State) -> list[Scalar]:
            return [*(own.begin(state) if remembered else ()), *inner.begin(state)]

        def recall(state: State, memory: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
            torque, kept = inner.recall(state, memory[remembered:])
            gain, following = self.gain, []
            if self.by_sign != 0:
                now, following = own.recall(state, memory[:remembered], step)
                gain = gain + self.by_sign * sign(now.total(state)[self.joint])
            torque[self.joint] = mul(gain, torque[self.joint])
            return torque, [*following, *kept]

        return Instants(own.keeps[:remembered], begin, recall)

    def _gain(self, motion: Motion) -> Float[ndarray, " samples"]:
        gain = np.full(len(motion), self.gain)
        if self.by_sign != 0:
            gain += self.by_sign * np.sign(self.reference.total(State.along(motion))[self.joint])
        return gain
