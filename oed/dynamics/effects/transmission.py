"""A joint that yields: the rigid-body torque passes a spring before the motor feels it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.effect import MeasurementEffect
from oed.dynamics.effects.linear_filter import respond
from oed.dynamics.motion import Motion


@dataclass(frozen=True)
class JointElasticity(MeasurementEffect):
    """tau_J = (1 + 2 zeta s/omega) / (1 + 2 zeta s/omega + s^2/omega^2) tau_rigid(q_motor).

    From Spong's two-mass joint (1987) with link inertia M, stiffness K and the position
    measured at the motor: M (q - tau_J/K)'' + g = tau_J, so that (1 + s^2 M/K) tau_J is the
    torque of the rigid arm, omega^2 = K/M; the damper lies beside the spring. To first order
    the residual is -tau_rigid''/omega^2. M is taken as constant over the motion. Friction on
    the motor's side does not pass the spring.

    Attributes:
        joint: Index of the joint.
        frequency: omega / 2 pi, of the arm on the spring with its motor held [Hz].
        damping: zeta.
        rigid_columns: The leading columns are the rigid body's; None if all are.
    """

    joint: int
    frequency: float
    damping: float = 0.05
    rigid_columns: int | None = None
    name = "joint_elasticity"

    def __post_init__(self) -> None:
        if self.frequency <= 0 or self.damping <= 0:
            raise ValueError(f"{self.frequency=} and {self.damping=} must be positive")

    def through(
        self,
        columns: Callable[[Motion], Float[ndarray, "samples joints columns"]],
        motion: Motion,
    ) -> Float[ndarray, "samples joints columns"]:
        """The columns with the joint's rigid-body part through the spring."""
        result = np.array(columns(motion))
        omega = 2 * np.pi * self.frequency
        damper, inertia = 2 * self.damping / omega, omega**-2
        row, rigid = slice(self.joint, self.joint + 1), slice(self.rigid_columns)
        result[:, row, rigid] = respond(
            motion.t, result[:, row, rigid], [damper, 1.0], [inertia, damper, 1.0]
        )
        return result
