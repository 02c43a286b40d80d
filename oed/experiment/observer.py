"""The high-gain observer that stands in for a velocity sensor (Calafiore 2001, 17a-b)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float
from numpy import ndarray
from scipy.linalg import expm


@dataclass(frozen=True)
class HighGainObserver:
    """Estimates position x_1 and velocity x_2 of every joint from its position.

    x_1' = x_2 + (H_p / eps)(q - x_1),  x_2' = (H_v / eps^2)(q - x_1).

    Attributes:
        position_gain: (n,) diagonal of H_p [-].
        velocity_gain: (n,) diagonal of H_v [-].
        epsilon: Time scale of the observer [s].

    Raises:
        ValueError: If lambda^2 + h_p lambda + h_v is not Hurwitz for a joint.
    """

    position_gain: tuple[float, ...]
    velocity_gain: tuple[float, ...]
    epsilon: float

    def __post_init__(self) -> None:
        if len(self.position_gain) != len(self.velocity_gain):
            raise ValueError(
                f"{len(self.position_gain)} position gains, {len(self.velocity_gain)} velocity gains"
            )
        if not self.epsilon > 0:
            raise ValueError(f"epsilon {self.epsilon:g} s must be positive")
        growth = self.poles().real.max(axis=1)
        if growth.max() >= 0:
            joint = int(np.argmax(growth))
            raise ValueError(
                f"joint {joint + 1}: lambda^2 + {self.position_gain[joint]:g} lambda + "
                f"{self.velocity_gain[joint]:g} is not Hurwitz"
            )

    @classmethod
    def paper(cls) -> HighGainObserver:
        """H_p = diag(7, 6.2), H_v = diag(2, 4), eps = 0.002 s (Calafiore 2001, section 4)."""
        return cls((7.0, 6.2), (2.0, 4.0), 0.002)

    @classmethod
    def uniform(cls, joints: int) -> HighGainObserver:
        """The same well-damped observer, both poles at 500 rad/s, on every joint."""
        return cls((2.0,) * joints, (1.0,) * joints, 0.002)

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.position_gain)

    def poles(self) -> Complex[ndarray, "joints 2"]:
        """Roots of lambda^2 + h_p lambda + h_v over epsilon [rad/s]."""
        roots = [
            np.roots([1.0, p, v])
            for p, v in zip(self.position_gain, self.velocity_gain, strict=True)
        ]
        return np.array(roots, dtype=complex) / self.epsilon

    def discretised(
        self, period: float
    ) -> tuple[
        Float[ndarray, "joints 2 2"], Float[ndarray, "joints 2"], Float[ndarray, "joints 2"]
    ]:
        """A, B and D of s(k+1) = A s(k) + B q(k), (x_1, x_2)(k) = s(k) + D q(k).

        Exact for a position that changes linearly between samples. The fast pole of the
        paper's joint 1 lies at 3350 rad/s: an Euler step of 1 ms would be unstable, and a
        position held for the step would make a steady velocity read several per cent low.
        """
        A, B, D = np.zeros((self.n, 2, 2)), np.zeros((self.n, 2)), np.zeros((self.n, 2))
        for j, (p, v) in enumerate(zip(self.position_gain, self.velocity_gain, strict=True)):
            gain_p, gain_v = p / self.epsilon, v / self.epsilon**2
            # States x_1, x_2, the position and its slope over the step.
            block = np.zeros((4, 4))
            block[0] = [-gain_p, 1.0, gain_p, 0.0]
            block[1] = [-gain_v, 0.0, gain_v, 0.0]
            block[2, 3] = 1.0
            step = expm(block * period)
            A[j] = step[:2, :2]
            D[j] = step[:2, 3] / period
            # The step's start weighs what the end does not; the end is carried to the next.
            B[j] = step[:2, 2] - D[j] + A[j] @ D[j]
        return A, B, D
