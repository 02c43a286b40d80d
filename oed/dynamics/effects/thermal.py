"""Friction that falls while the joint warms up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.scalars import Scalar, exp, mul


@dataclass(frozen=True)
class ThermalDrift(Effect):
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

    def __post_init__(self) -> None:
        if self.time_constant <= 0:
            raise ValueError(f"{self.time_constant=} must be positive")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Excess of viscous and of Coulomb friction at the start."""
        tag = self.joint + 1
        return (
            Parameter(f"cold_Fv_{tag}", "N m s/rad", self.joint),
            Parameter(f"cold_Fc_{tag}", "N m", self.joint),
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Time and the joint's velocity."""
        return ("time", f"dq_{self.joint + 1}")

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """exp(-t/T) dq_j, exp(-t/T) sgn(dq_j)."""
        dq = state.dq[self.joint]
        cold = exp(-since(state.t, self.start) / self.time_constant)
        cold = cold if np.ndim(cold) else float(cold)  # NumPy's scalars do not meet symbols
        return [
            {self.joint: mul(cold, dq)},
            {self.joint: mul(cold, state.sign(dq, self.width))},
        ]


@dataclass(frozen=True)
class FrictionJump(Effect):
    """a dq_j + b sgn(dq_j) from a moment on, which warmth does not do.

    Attributes:
        joint: Index of the joint.
        moment: Time since `start` [s].
        start: As of `ThermalDrift`.
        width: Velocity over which the sign turns [rad/s]; 0 for the exact sign.
    """

    joint: int
    moment: float
    start: float | None = None
    width: float = 0.0
    name = "friction_jump"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """What viscous and Coulomb friction change by."""
        tag = self.joint + 1
        return (
            Parameter(f"jump_Fv_{tag}", "N m s/rad", self.joint),
            Parameter(f"jump_Fc_{tag}", "N m", self.joint),
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Time and the joint's velocity."""
        return ("time", f"dq_{self.joint + 1}")

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """The joint's velocity and its sign, zero before the moment."""
        dq = state.dq[self.joint]
        later = np.asarray(since(state.t, self.start) >= self.moment, dtype=float)
        gate = float(later) if later.ndim == 0 else later
        return [
            {self.joint: mul(gate, dq)},
            {self.joint: mul(gate, state.sign(dq, self.width))},
        ]


def since(t: Scalar, start: float | None) -> Scalar:
    """Time since a start, the first sample if None [s]; one instant is its own first."""
    if start is not None:
        return t - start
    return t - t[0] if isinstance(t, np.ndarray) and t.ndim else 0.0
