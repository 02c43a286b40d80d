"""An encoder disc that is off centre or tilted: the angle is wrong by waves of itself."""

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
    """True position q + sum over n of a_n sin(n q) + b_n cos(n q).

    n = 1 for a disc off centre, 2 for a tilted one or two poles of unequal gain, more for more
    poles (Hanselman 1990 for resolvers).

    Attributes:
        joint: Index of the joint.
        waves: a_n and b_n [rad], one after the other for each n.
        harmonics: n, periods a joint turn.
    """

    joint: int
    waves: tuple[float, ...]
    harmonics: tuple[float, ...] = (1.0,)
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
        shift = slope = bend = 0.0
        for k, n in enumerate(self.harmonics):
            a, b = self.waves[2 * k : 2 * k + 2]
            wave = a * sin(n * q) + b * cos(n * q)
            shift += wave
            slope += n * (a * cos(n * q) - b * sin(n * q))
            bend += n**2 * wave
        return q + shift, dq * (1.0 + slope), ddq * (1.0 + slope) - bend * dq**2


@dataclass(frozen=True)
class EccentricityColumns(Effect):
    """Change of the predicted torque per unit of each a and b, for parameters known so far."""

    joint: int
    reference: ReferenceTorque
    harmonics: tuple[float, ...] = (1.0,)
    name = "encoder_eccentricity"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The coefficients a and b of each wave."""
        return tuple(
            Parameter(f"encoder{_times(n)}_{phase}_{self.joint + 1}", "rad", self.joint)
            for n in self.harmonics
            for phase in ("sin", "cos")
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's coordinates."""
        return tuple(f"{x}_{self.joint + 1}" for x in ("q", "dq", "ddq"))

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """Central differences in each a and b."""
        return [self._slope(wave, state) for wave in range(2 * len(self.harmonics))]

    def _slope(self, wave: int, state: State) -> Mapping[int, Scalar]:
        above, below = (
            self.reference.total(self._moved(wave, step, state)) for step in (STEP, -STEP)
        )
        return {
            joint: mul(0.5 / STEP, high - low)
            for joint, (high, low) in enumerate(zip(above, below, strict=True))
        }

    def _moved(self, wave: int, size: float, state: State) -> State:
        waves = [0.0] * (2 * len(self.harmonics))
        waves[wave] = size
        error = EncoderEccentricity(self.joint, tuple(waves), self.harmonics)
        j = self.joint
        true = error.corrected(state.q[j], state.dq[j], state.ddq[j])
        q, dq, ddq = (
            [*before[:j], value, *before[j + 1 :]]
            for before, value in zip((state.q, state.dq, state.ddq), true, strict=True)
        )
        return replace(state, q=q, dq=dq, ddq=ddq, sampled=None)


def _times(harmonic: float) -> str:
    """What tells the wave of a harmonic from that of a disc off centre."""
    return "" if harmonic == 1 else f"{harmonic:.6g}"
