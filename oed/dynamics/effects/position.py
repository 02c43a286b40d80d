"""Torque that depends on where the joint is: ripple, uneven friction, a spring."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.scalars import Scalar, cos, mul, sin

LINEAR, PROGRESSIVE = 1, 3  # orders of a spring


@dataclass(frozen=True)
class TorqueRipple(Effect):
    """Sum over n of a_n cos(n q_j) + b_n sin(n q_j), whatever the direction of motion.

    Cogging and commutation ripple have n = motor poles times gear ratio or multiples (Holtz
    and Springob 1996), a harmonic drive of ratio N has n = 2 N (Taghirad and Belanger 1998),
    gear meshing the number of teeth.

    Attributes:
        joint: Index of the joint.
        harmonics: n, periods a joint turn.
    """

    joint: int
    harmonics: tuple[float, ...]
    name = "torque_ripple"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """a_n and b_n."""
        return _waves("ripple", self.harmonics, self.joint)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's position."""
        return (f"q_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """cos(n q_j), sin(n q_j)."""
        q = state.q[self.joint]
        waves = (wave(n * q) for n in self.harmonics for wave in (cos, sin))
        return [{self.joint: value} for value in waves]


@dataclass(frozen=True)
class PositionFriction(Effect):
    """Sum over k of (a_k cos(k q_j) + b_k sin(k q_j)) sgn(dq_j).

    Coulomb friction that varies around the turn, from gears out of round and misaligned
    bearings (Armstrong 1988; Popovic and Goldenberg 1998).

    Attributes:
        joint: Index of the joint.
        harmonics: k, periods a joint turn.
        width: Velocity over which the sign turns [rad/s]; 0 for the exact sign.
    """

    joint: int
    harmonics: tuple[float, ...]
    width: float = 0.0
    name = "position_dependent_friction"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """a_k and b_k."""
        return _waves("Fq", self.harmonics, self.joint)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's position and the sign of its velocity."""
        return (f"q_{self.joint + 1}", f"dq_{self.joint + 1}")

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """cos(k q_j) sgn(dq_j), sin(k q_j) sgn(dq_j)."""
        q = state.q[self.joint]
        direction = state.sign(state.dq[self.joint], self.width)
        waves = (wave(k * q) for k in self.harmonics for wave in (cos, sin))
        return [{self.joint: mul(value, direction)} for value in waves]


@dataclass(frozen=True)
class JointSpring(Effect):
    """k (q_j - q_0), with higher powers where it tightens: cables, hoses, a balancing spring.

    Linear in powers of q_j - centre; the constant is tau_c = k (centre - q_0) of a linear spring.
    Wang et al. 2019 identify such springs, and polynomials for cables, on the da Vinci arms.

    Attributes:
        joint: Index of the joint.
        centre: Middle of the range moved in, so that the columns differ [rad].
        constant: Whether to have the constant; False beside a `TorqueOffset`.
        order: Highest power, `LINEAR` or `PROGRESSIVE`.
    """

    joint: int
    centre: float = 0.0
    constant: bool = True
    order: int = LINEAR
    name = "joint_spring"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """k, the coefficients of higher powers, and the spring's torque at the centre."""
        tag = self.joint + 1
        powers = [Parameter(f"spring_{tag}", "N m/rad", self.joint)]
        powers += [
            Parameter(f"spring{k}_{tag}", f"N m/rad^{k}", self.joint)
            for k in range(2, self.order + 1)
        ]
        if not self.constant:
            return tuple(powers)
        return (*powers, Parameter(f"spring_torque_{tag}", "N m", self.joint))

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's position."""
        return (f"q_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """q_j - centre, its powers, 1."""
        stretch = state.q[self.joint] - self.centre
        powers = [stretch]
        for _ in range(1, self.order):
            powers.append(mul(powers[-1], stretch))
        columns: list[Mapping[int, Scalar]] = [{self.joint: power} for power in powers]
        return [*columns, {self.joint: 1.0}] if self.constant else columns


def _waves(symbol: str, harmonics: tuple[float, ...], joint: int) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(f"{symbol}{n:.6g}_{phase}_{joint + 1}", "N m", joint)
        for n in harmonics
        for phase in ("cos", "sin")
    )
