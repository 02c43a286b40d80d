"""Friction that changes in time, or with temperature: it falls as a joint warms up, or jumps."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from oed.dynamics.effects.effect import Columns, Effect, Parameter, State
from oed.dynamics.scalars import Scalar, exp, mul


class ChangingFriction(Effect):
    """A share that changes in time of a dq_j + b sgn(dq_j)."""

    joint: int
    width: float
    prefix: ClassVar[str]

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Viscous and Coulomb friction of which it is the share."""
        tag = self.joint + 1
        return (
            Parameter(f"{self.prefix}_Fv_{tag}", "N m s/rad", self.joint),
            Parameter(f"{self.prefix}_Fc_{tag}", "N m", self.joint),
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Time and the joint's velocity."""
        return ("time", f"dq_{self.joint + 1}")

    @property
    def keeps(self) -> tuple[str, ...]:
        """Time since the start [s]."""
        return (f"time of {self.name} {self.joint + 1}",)

    def begin(self, state: State) -> Sequence[Scalar]:  # noqa: ARG002  # whatever it is
        """None has gone by."""
        return (0.0,)

    def recall(
        self, state: State, memory: Sequence[Scalar], step: float
    ) -> tuple[Columns, Sequence[Scalar]]:
        """The share of dq_j and of sgn(dq_j) at that time."""
        since_then = dataclasses.replace(self, start=0.0)  # pyright: ignore[reportArgumentType]
        now = dataclasses.replace(state, t=memory[0])
        return since_then.entries(now), (memory[0] + step,)

    @abstractmethod
    def share(self, state: State) -> Scalar:
        """The share at a time or a temperature."""

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """The share of dq_j and of sgn(dq_j)."""
        dq, share = state.dq[self.joint], self.share(state)
        if isinstance(share, np.generic):  # NumPy's scalars do not meet symbols
            share = float(share)
        return [
            {self.joint: mul(share, dq)},
            {self.joint: mul(share, state.sign(dq, self.width))},
        ]


@dataclass(frozen=True)
class ThermalDrift(ChangingFriction):
    """exp(-t/T) (a dq_j + b sgn(dq_j)), over time since the start of the recording.

    Grease thins with temperature: cold friction is larger and decays with the time constant
    of the housing (Bittencourt and Gunnarsson 2012; Simoni et al. 2015).

    Attributes:
        joint: Index of the joint.
        time_constant: T [s].
        start: Time at which the arm was cold [s]; None for the first sample of each
            recording, every one being a session of its own.
        width: Velocity over which the sign turns [rad/s]; 0 for the exact sign.
    """

    joint: int
    time_constant: float
    start: float | None = None
    width: float = 0.0
    name = "thermal_drift"
    prefix = "cold"

    def __post_init__(self) -> None:
        if self.time_constant <= 0:
            raise ValueError(f"{self.time_constant=} must be positive")

    def share(self, state: State) -> Scalar:
        """exp(-t/T)."""
        return exp(-since(state.t, self.start) / self.time_constant)


@dataclass(frozen=True)
class WarmFriction(ChangingFriction):
    """(Θ_j - Θ_r) (a dq_j + b sgn(dq_j)), Θ_j the temperature that was measured.

    Viscous friction falls with temperature, and so does what it adds at low speed; over the range
    of one session both do nearly in proportion to it (Bittencourt and Gunnarsson 2012).

    Attributes:
        joint: Index of the joint.
        reference: Θ_r, at which the friction is the base model's [degrees Celsius]; a motion
            along which no temperature is known is taken to be at it.
        width: Velocity over which the sign turns [rad/s]; 0 for the exact sign.
    """

    joint: int
    reference: float
    width: float = 0.0
    name = "thermal_drift"
    prefix = "warming"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Change of viscous and of Coulomb friction for each kelvin."""
        viscous, coulomb = super().parameters
        return (
            dataclasses.replace(viscous, unit="N m s/(rad K)"),
            dataclasses.replace(coulomb, unit="N m/K"),
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's temperature and velocity."""
        return (f"temperature_{self.joint + 1}", f"dq_{self.joint + 1}")

    def share(self, state: State) -> Scalar:
        """How much warmer the joint is than the reference [K]."""
        if state.temperature is None:
            return 0.0
        return state.temperature[:, self.joint] - self.reference

    @property
    def keeps(self) -> tuple[str, ...]:
        """The temperature [degrees Celsius], which whoever measures it writes there."""
        return (f"temperature_{self.joint + 1}",)

    def begin(self, state: State) -> Sequence[Scalar]:  # noqa: ARG002
        """That of the base model."""
        return (self.reference,)

    def recall(
        self,
        state: State,
        memory: Sequence[Scalar],
        step: float,  # noqa: ARG002  # warmth comes from outside
    ) -> tuple[Columns, Sequence[Scalar]]:
        """The columns at that temperature."""
        (temperature,) = memory
        dq, share = state.dq[self.joint], temperature - self.reference
        both = (dq, state.sign(dq, self.width))
        return [{self.joint: mul(share, x)} for x in both], (temperature,)


def since(t: Scalar, start: float | None) -> Scalar:
    """Time since a start, the first sample if None [s]; one instant is its own first."""
    if start is not None:
        return t - start
    return t - t[0] if isinstance(t, np.ndarray) and t.ndim else 0.0
