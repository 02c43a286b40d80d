"""An encoder disc that is mounted off centre: the angle is wrong by a sine of itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.effect import Effect, MeasurementEffect, Parameter, State
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.motion import Motion, with_joint
from oed.dynamics.scalars import Scalar, cos, mul, sin

# Central differences of the torque: the error is this squared, far above rounding.
STEP = 1e-4  # [rad]


@dataclass(frozen=True)
class EncoderEccentricity(MeasurementEffect):
    """True position q + a sin(n q) + b cos(n q) = q + e sin(n q + phi), e^2 = a^2 + b^2.

    n = 1 for a disc off centre, 2 for a tilted one or two poles of unequal gain (Hanselman
    1990 for resolvers).

    Attributes:
        joint: Index of the joint.
        sine: a [rad].
        cosine: b [rad].
        harmonic: n, periods a joint turn.
    """

    joint: int
    sine: float
    cosine: float
    harmonic: float = 1.0
    name = "encoder_eccentricity"

    def through(
        self,
        columns: Callable[[Motion], Float[ndarray, "samples joints columns"]],
        motion: Motion,
    ) -> Float[ndarray, "samples joints columns"]:
        """The columns along the true motion."""
        states = [getattr(motion, x)[:, self.joint] for x in ("q", "dq", "ddq")]
        true = self.corrected(*states)
        return columns(with_joint(motion, self.joint, true))

    def corrected(self, q: Scalar, dq: Scalar, ddq: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """True position, velocity and acceleration of the joint."""
        n = self.harmonic
        shift = self.sine * sin(n * q) + self.cosine * cos(n * q)
        slope = n * (self.sine * cos(n * q) - self.cosine * sin(n * q))
        return q + shift, dq * (1.0 + slope), ddq * (1.0 + slope) - n**2 * shift * dq**2


@dataclass(frozen=True)
class EccentricityColumns(Effect):
    """Change of the predicted torque per unit of a and of b, for parameters known so far."""

    joint: int
    reference: ReferenceTorque
    harmonic: float = 1.0
    name = "encoder_eccentricity"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The coefficients a and b."""
        tag = self.joint + 1
        return tuple(
            Parameter(f"encoder_{phase}_{tag}", "rad", self.joint) for phase in ("sin", "cos")
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's coordinates."""
        return tuple(f"{x}_{self.joint + 1}" for x in ("q", "dq", "ddq"))

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """Central differences in a and b."""
        return [self._slope(sine, 1.0 - sine, state) for sine in (1.0, 0.0)]

    def _slope(self, sine: float, cosine: float, state: State) -> Mapping[int, Scalar]:
        above, below = (
            self.reference.total(self._moved(step * sine, step * cosine, state))
            for step in (STEP, -STEP)
        )
        return {
            joint: mul(0.5 / STEP, high - low)
            for joint, (high, low) in enumerate(zip(above, below, strict=True))
        }

    def _moved(self, sine: float, cosine: float, state: State) -> State:
        error = EncoderEccentricity(self.joint, sine, cosine, self.harmonic)
        j = self.joint
        true = error.corrected(state.q[j], state.dq[j], state.ddq[j])
        q, dq, ddq = (
            [*before[:j], value, *before[j + 1 :]]
            for before, value in zip((state.q, state.dq, state.ddq), true, strict=True)
        )
        return replace(state, q=q, dq=dq, ddq=ddq)
