"""Torque that depends on where the joint is: ripple, uneven friction, a spring."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.effects.parameter import Demand
from oed.dynamics.scalars import Scalar, add, cos, magnitude, mul, sin

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
    part = "position"

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
    """k (q_j - q_0), with more where it tightens: cables, hoses, a balancing spring.

    Linear in powers of q_j - centre; the constant is tau_c = k (centre - q_0) of a linear spring.
    Wang et al. 2019 identify such springs, and polynomials for cables, on the da Vinci arms. A cable
    that goes slack has no polynomial: its stiffness changes at bends.

    Attributes:
        joint: Index of the joint.
        centre: Middle of the range moved in, so that the columns differ [rad].
        constant: Whether to have the constant; False beside a `TorqueOffset`.
        order: Highest power, `LINEAR` or `PROGRESSIVE`.
        bends: Positions at which the stiffness changes, in rising order [rad].
    """

    joint: int
    centre: float = 0.0
    constant: bool = True
    order: int = LINEAR
    bends: tuple[float, ...] = ()
    name = "joint_spring"
    part = "position"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """k, the coefficients of higher powers, changes of k at bends, the torque at the centre."""
        tag = self.joint + 1
        powers = [Parameter(f"spring_{tag}", "N m/rad", self.joint)]
        powers += [
            Parameter(f"spring{k}_{tag}", f"N m/rad^{k}", self.joint)
            for k in range(2, self.order + 1)
        ]
        changes = (
            Parameter(f"spring_bend{k}_{tag}", "N m/rad", self.joint)
            for k in range(1, len(self.bends) + 1)
        )
        constant = [Parameter(f"spring_torque_{tag}", "N m", self.joint)] * self.constant
        return (*powers, *changes, *constant)

    @property
    def demands(self) -> tuple[Demand, ...]:
        """A spring pulls back in each stretch between bends; of a curved one its range decides."""
        if self.order > LINEAR:
            return ()
        rest = (0.0,) * (len(self.parameters) - 1 - len(self.bends))
        rows = (
            (1.0,) * (1 + k) + (0.0,) * (len(self.bends) - k) for k in range(1 + len(self.bends))
        )
        return tuple(
            Demand((*row, *rest), 0.0, f"stiffness {k} of joint {self.joint + 1} >= 0")
            for k, row in enumerate(rows, 1)
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's position."""
        return (f"q_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """q_j - centre, its powers, what of q_j lies beyond each bend, 1."""
        q = state.q[self.joint]
        stretch = q - self.centre
        powers = [stretch]
        for _ in range(1, self.order):
            powers.append(mul(powers[-1], stretch))
        beyond = [0.5 * add(q - bend, magnitude(q - bend)) for bend in self.bends]
        columns = [*powers, *beyond, *([1.0] if self.constant else [])]
        return [{self.joint: column} for column in columns]


def _waves(symbol: str, harmonics: tuple[float, ...], joint: int) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(f"{symbol}{n:.6g}_{phase}_{joint + 1}", "N m", joint)
        for n in harmonics
        for phase in ("cos", "sin")
    )
