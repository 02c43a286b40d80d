"""Coulomb and viscous friction of a joint (Calafiore 2001, eq. 15)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.scalars import Scalar, power


@dataclass(frozen=True)
class Coulomb(Effect):
    """F_c sgn(dq_j).

    Attributes:
        joint: Index of the joint.
        width: Velocity over which the sign turns, tanh(dq / width) [rad/s]; 0 for the
            exact sign. Measured velocity cannot tell its sign below its own noise.
        gradual: Whether it turns as dq / sqrt(dq^2 + width^2) instead, which lacks (width / dq)^2 / 2
            of the whole at speeds where tanh has long arrived.
    """

    joint: int
    width: float = 0.0
    gradual: bool = False
    name = "coulomb"
    joint_term = "friction"
    dissipates = True

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """F_c."""
        return (Parameter(f"Fc_{self.joint + 1}", "N m", self.joint),)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's velocity."""
        return (f"dq_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """sgn(dq_j)."""
        dq = state.dq[self.joint]
        if self.gradual and self.width > state.sign_width:
            return [{self.joint: dq / (power(dq, 2.0) + self.width**2) ** 0.5}]
        return [{self.joint: state.sign(dq, self.width)}]


@dataclass(frozen=True)
class Viscous(Effect):
    """F_v dq_j."""

    joint: int
    name = "viscous"
    joint_term = "damping"
    dissipates = True

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """F_v."""
        return (Parameter(f"Fv_{self.joint + 1}", "N m s/rad", self.joint),)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's velocity."""
        return (f"dq_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """dq_j."""
        return [{self.joint: state.dq[self.joint]}]
