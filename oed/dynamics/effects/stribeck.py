"""Friction that falls with speed at low speed: the Stribeck effect."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.scalars import Scalar, exp, magnitude, power

# Below this tail the algebraic decay is the exponential one to rounding.
EXPONENTIAL = 1e-9


@dataclass(frozen=True)
class Stribeck(Effect):
    """F_S d(|dq_j| / v_S) sgn(dq_j), with d falling from one to zero.

    d(x) = (1 + c x^delta)^(-1/c) for a tail c in (0, 1], exp(-x^delta) for c = 0. The family
    holds the Gaussian (delta = 2, c = 0), Tustin's exponential (delta = 1, c = 0; Bo and
    Pavelescu 1982 leave delta free) and Hess and Soom's 1 / (1 + x^2) (delta = 2, c = 1); see
    Armstrong-Helouvry, Dupont and Canudas de Wit 1994, section 2.2.

    Attributes:
        joint: Index of the joint.
        speed: v_S [rad/s].
        exponent: delta.
        tail: c, how slowly the end dies out, 0 to 1.
        width: Velocity over which the sign turns [rad/s]; 0 for the exact sign.
    """

    joint: int
    speed: float
    exponent: float = 2.0
    tail: float = 0.0
    width: float = 0.0
    name = "stribeck"
    dissipates = True

    def __post_init__(self) -> None:
        if self.speed <= 0 or self.exponent <= 0 or not 0 <= self.tail <= 1:
            raise ValueError(
                f"{self.speed=} and {self.exponent=} must be positive, {self.tail=} in 0 to 1"
            )

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """F_S."""
        return (Parameter(f"Fs_{self.joint + 1}", "N m", self.joint),)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's velocity."""
        return (f"dq_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """d(|dq_j| / v_S) sgn(dq_j)."""
        dq = state.dq[self.joint]
        decay = self._decay(power(magnitude(dq) / self.speed, self.exponent))
        return [{self.joint: decay * state.sign(dq, self.width)}]

    def _decay(self, x: Scalar) -> Scalar:
        if self.tail < EXPONENTIAL:
            return exp(-x)
        return power(1.0 + self.tail * x, -1.0 / self.tail)
