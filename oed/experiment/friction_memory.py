"""Friction that remembers: what a joint does around standstill."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from oed.dynamics.effects import State
from oed.dynamics.scalars import Scalar, exp, magnitude


class MemoryTorque(ABC):
    """A torque with states of its own, for simulation."""

    @property
    @abstractmethod
    def states(self) -> int:
        """Number of states."""

    @property
    @abstractmethod
    def fastest(self) -> float:
        """Greatest decay rate per unit of joint speed [1/rad], for Drake's choice of step."""

    @abstractmethod
    def rate(self, state: State, memory: Sequence[Scalar]) -> Sequence[Scalar]:
        """Time derivative of the states."""

    @abstractmethod
    def torque(self, state: State, memory: Sequence[Scalar]) -> Mapping[int, Scalar]:
        """Torque that the joint must overcome [N m], by joint."""


@dataclass(frozen=True)
class BristleFriction(MemoryTorque):
    """Coulomb friction through bristles that bend before they slip.

    With z the deflection, z' = dq - |dq| z / z_s(dq) and torque k z, where k z_s is the
    sliding friction (Dahl 1968; with a Stribeck rise LuGre, Canudas de Wit et al. 1995, its
    micro-damping left to the joint's viscous friction). It sticks and slips without a
    switch: sliding steadily it is F_c sgn(dq) exactly, and at rest it holds.

    Attributes:
        joint: Index.
        coulomb: F_c, friction of fast sliding [N m].
        deflection: Bending at which the bristles slip at F_c [rad].
        static_rise: F_s - F_c, the rise towards standstill [N m].
        stribeck_speed: Speed scale of that rise [rad/s].
    """

    joint: int
    coulomb: float
    deflection: float = 1e-3
    static_rise: float = 0.0
    stribeck_speed: float = 0.1

    @property
    def states(self) -> int:
        """The deflection."""
        return 1

    @property
    def fastest(self) -> float:
        """1 / deflection."""
        return 1.0 / self.deflection

    def rate(self, state: State, memory: Sequence[Scalar]) -> Sequence[Scalar]:
        """Velocity less what has slipped."""
        speed = state.dq[self.joint]
        slip = magnitude(speed) * memory[0] / self._limit(speed)
        return [speed - slip]

    def torque(self, state: State, memory: Sequence[Scalar]) -> Mapping[int, Scalar]:
        """Stiffness times deflection."""
        del state
        return {self.joint: self.coulomb / self.deflection * memory[0]}

    def _limit(self, speed: Scalar) -> Scalar:
        ratio = speed / self.stribeck_speed
        rise = self.static_rise / self.coulomb * exp(-ratio * ratio)
        return self.deflection * (1.0 + rise)
