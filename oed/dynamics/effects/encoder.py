"""An encoder disc that is off centre or tilted: the angle is wrong by waves of itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.effects.effect import Parameter, State
from oed.dynamics.effects.measurement_effect import Instants, MeasurementEffect
from oed.dynamics.effects.on_reference import FollowsTorque
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.motion import Motion, with_joint
from oed.dynamics.scalars import Scalar, add, cos, mul, sin, total


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
    not_simulated = "the encoder is wrong, and a simulation moves the true angle"

    def through(
        self,
        columns: Callable[[Motion], Float[ndarray, "samples joints columns"]],
        motion: Motion,
        rigid: Bool[ndarray, " columns"],  # noqa: ARG002  # all columns alike
    ) -> Float[ndarray, "samples joints columns"]:
        """The columns along the true motion."""
        return columns(motion.changed(self, lambda: self._true(motion)))

    def _true(self, motion: Motion) -> Motion:
        states = [getattr(motion, x)[:, self.joint] for x in ("q", "dq", "ddq")]
        return with_joint(motion, self.joint, self.corrected(*states))

    def after(self, inner: Instants, joints: int, step: float) -> Instants:  # noqa: ARG002  # nothing lasts
        """The torque of the true state."""

        def true(state: State) -> State:
            j = self.joint
            return state.with_joint(j, *self.corrected(state.q[j], state.dq[j], state.ddq[j]))

        return Instants(
            (),
            lambda state: inner.begin(true(state)),
            lambda state, memory: inner.recall(true(state), memory),
        )

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
class EccentricityColumns(FollowsTorque):
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
        """Derivatives by each a and b, by way of the joint's position, velocity and acceleration."""
        j, columns = self.joint, []
        own = self.reference.slopes(state, j), self.reference.slopes_beside(state, j)
        q, dq, ddq = state.q[j], state.dq[j], state.ddq[j]
        for n in self.harmonics:
            s, c = sin(n * q), cos(n * q)
            for shift, slope in ((s, n * c), (c, -n * s)):
                bend = slope * ddq - n**2 * shift * dq**2
                column = {}
                for i, (rigid, beside) in enumerate(zip(*own, strict=True)):
                    terms = (
                        mul(add(rigid[0], beside[0]), shift),
                        mul(add(mul(rigid[1], dq), beside[1]), slope),
                        mul(add(rigid[2], beside[2]), bend),
                    )
                    column[i] = total(terms)
                columns.append(column)
        return columns


def _times(harmonic: float) -> str:
    """What tells the wave of a harmonic from that of a disc off centre."""
    return "" if harmonic == 1 else f"{harmonic:.6g}"
