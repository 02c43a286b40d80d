"""Viscous friction that is not proportional to speed, or not the same both ways."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.effects.parameter import Demand, not_negative
from oed.dynamics.scalars import Scalar, magnitude, power


@dataclass(frozen=True)
class NonlinearViscous(Effect):
    """F_n |dq_j|^alpha / (1 + |dq_j| / v_0) sgn(dq_j).

    A power of speed (Waiboer, Aarts and Jonker 2005 find alpha below one in geared joints;
    Tuttle and Seering 1996 a cubic rise in harmonic drives), or shear thinning with
    alpha = 1 and a finite v_0.

    Attributes:
        joint: Index of the joint.
        exponent: alpha.
        thinning: 1 / v_0 [s/rad], 0 for a pure power.
        width: Velocity over which the sign turns [rad/s]; 0 for the exact sign.
    """

    joint: int
    exponent: float = 1.0
    thinning: float = 0.0
    width: float = 0.0
    name = "nonlinear_viscous"

    def __post_init__(self) -> None:
        if self.exponent <= 0 or self.thinning < 0:
            raise ValueError(f"{self.exponent=} must be positive, {self.thinning=} at least 0")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """F_n."""
        unit = f"N m (s/rad)^{self.exponent:.3g}"
        return (Parameter(f"Fn_{self.joint + 1}", unit, self.joint),)

    @property
    def demands(self) -> tuple[Demand, ...]:
        """Friction that sets off steeper than viscous friction brakes; what bends later may fall."""
        return not_negative(self.parameters) if self.exponent < 1 else ()

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's velocity."""
        return (f"dq_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """The odd function of velocity."""
        dq = state.dq[self.joint]
        speed = magnitude(dq)
        rise = power(speed, self.exponent) / (1.0 + self.thinning * speed)
        return [{self.joint: rise * state.sign(dq, self.width)}]


@dataclass(frozen=True)
class AsymmetricViscous(Effect):
    """F_a |dq_j|: viscous friction that differs between the two directions.

    F_v + F_a holds one way, F_v - F_a the other (Canudas de Wit, Astrom and Braun 1987).
    """

    joint: int
    name = "asymmetric_viscous"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """F_a."""
        return (Parameter(f"Fa_{self.joint + 1}", "N m s/rad", self.joint),)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's velocity."""
        return (f"dq_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """|dq_j|."""
        return [{self.joint: magnitude(state.dq[self.joint])}]
