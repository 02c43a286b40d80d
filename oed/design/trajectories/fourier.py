"""Finite Fourier series of one fundamental: periodic, and linear in its coefficients.

Swevers et al. 1997, "Optimal robot excitation and identification".
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy.linalg
from jaxtyping import Float
from numpy import ndarray

from oed.design.trajectories.linear import LinearClass
from oed.robot import JointLimits

BASES_KEPT = 32  # the criterion, the limits and the reports each have their instants
MOST_HARMONICS = 200  # of a series that is read; a design has five, or twenty


@dataclass(frozen=True)
class FourierClass(LinearClass):
    """q_j(t) = offset_j + sum_k s_jk sin(k w t) + c_jk cos(k w t), w = 2 pi / horizon.

    Each joint's own variables are the offset, the W sine and the W cosine coefficients; with
    `at_rest`, coordinates of the subspace in which velocity and acceleration are zero at the
    ends. z holds joint after joint.

    Attributes:
        horizon: One period [s].
        limits: Position, velocity and acceleration limits give the box.
        harmonics: W.
        at_rest: Whether the motion starts and ends at rest.
    """

    horizon: float
    limits: JointLimits
    harmonics: int = 5
    at_rest: bool = False
    name = "fourier"
    is_periodic = True

    def __post_init__(self) -> None:
        if not np.isfinite(self.limits.position).all():
            raise ValueError("a Fourier class needs finite position limits of every joint")
        if self.at_rest and self.harmonics < 2:
            raise ValueError(f"{self.harmonics=} harmonic cannot start and end at rest")

    @property
    def fundamental(self) -> float:
        """Angular frequency w of the first harmonic [rad/s]."""
        return 2 * np.pi / self.horizon

    @cached_property
    def bounds(self) -> Float[ndarray, "size 2"]:  # pyright: ignore[reportIncompatibleMethodOverride]  # a property too, and cached
        """A box that cuts off no admissible motion.

        A coefficient of a function within +-M is at most 4 M / pi, and so are, divided by
        k w and (k w)^2, those of its derivatives.
        """
        orders = np.arange(1, self.harmonics + 1) * self.fundamental
        limits = self.limits
        reach = np.diff(limits.position, axis=1) / 2
        speed, acceleration = (
            np.abs(x).max(axis=1)[:, None] for x in (limits.velocity, limits.acceleration)
        )
        largest = np.minimum(np.minimum(reach, speed / orders), acceleration / orders**2)
        largest = np.tile(4 / np.pi * largest, (1, 2)) @ np.abs(self._subspace[1:, 1:])
        lower = np.concatenate([limits.position[:, :1], -largest], axis=1)
        upper = np.concatenate([limits.position[:, 1:], largest], axis=1)
        return np.stack([lower.reshape(-1), upper.reshape(-1)], axis=1)

    @property
    def own(self) -> int:
        """Number of each joint's own variables."""
        return self._subspace.shape[1]

    def basis(self, t: Float[ndarray, " samples"], order: int) -> Float[ndarray, "samples own"]:
        """Derivative of position by a joint's own variables."""
        series = _series(
            np.ascontiguousarray(t, dtype=float).tobytes(), self.horizon, self.harmonics, order
        )
        return series @ self._subspace if self.at_rest else series

    def derivative_bound(self, z: Float[ndarray, " size"], order: int) -> Float[ndarray, " joints"]:
        """sum_k of the harmonics' magnitudes times (k w)^order."""
        _, sines, cosines = self._parts(z)
        orders = np.arange(1, self.harmonics + 1) * self.fundamental
        return np.hypot(sines, cosines) @ orders**order

    def swing(
        self,
        middle: Float[ndarray, " joints"],
        amplitude: Float[ndarray, " joints"],
        rate: Float[ndarray, " joints"],
    ) -> Float[ndarray, " size"] | None:
        """The sine of the nearest harmonic; a series at rest at its ends holds no single sine."""
        if self.at_rest:
            return None
        own = np.zeros((self.joints, self.own))
        own[:, 0] = middle
        cycles = np.clip(np.round(rate / self.fundamental), 1, self.harmonics)
        own[np.arange(self.joints), cycles.astype(int)] = amplitude
        return own.reshape(-1)

    def slower(self, scale: float) -> FourierClass:
        """The same series over a longer period."""
        return dataclasses.replace(self, horizon=self.horizon / scale)

    def describe(self, z: Float[ndarray, " size"]) -> dict[str, ndarray]:
        """Offset (n,), sine and cosine coefficients (n, W)."""
        offset, sines, cosines = self._parts(z)
        fundamental = np.array(self.fundamental)
        return {"offset": offset, "sine": sines, "cosine": cosines, "fundamental": fundamental}

    @classmethod
    def restore(
        cls, horizon: float, limits: JointLimits, coefficients: Mapping[str, ndarray]
    ) -> tuple[FourierClass, Float[ndarray, " size"]]:
        """The series of these coefficients, whether or not it is at rest at its ends."""
        parts = [coefficients.get(part, np.empty(0)) for part in ("offset", "sine", "cosine")]
        shapes, joints = [part.shape for part in parts], len(limits.position)
        harmonics = shapes[1][1] if parts[1].ndim == 2 else 0
        if harmonics > MOST_HARMONICS:
            raise ValueError(f"{harmonics} harmonics are more than {MOST_HARMONICS}")
        if shapes != [(joints,), (joints, harmonics), (joints, harmonics)] or not harmonics:
            raise ValueError(
                f"offset, sine and cosine have shapes {shapes}, not those of a series of "
                f"{joints} joints"
            )
        z = np.concatenate([parts[0][:, None], *parts[1:]], axis=1).reshape(-1)
        return cls(horizon, limits, harmonics), z

    def _parts(self, z: Float[ndarray, " size"]) -> tuple[ndarray, ndarray, ndarray]:
        full = np.asarray(z, dtype=float).reshape(self.joints, -1) @ self._subspace.T
        return full[:, 0], full[:, 1 : 1 + self.harmonics], full[:, 1 + self.harmonics :]

    @cached_property
    def _subspace(self) -> Float[ndarray, "series own"]:
        """Orthonormal coordinates of the series: all, or those at rest at the ends."""
        size = 1 + 2 * self.harmonics
        if not self.at_rest:
            return np.eye(size)
        order = np.arange(1, self.harmonics + 1)
        zero = np.zeros(self.harmonics)
        # q'(0) = w sum k s_k and q''(0) = -w^2 sum k^2 c_k
        conditions = np.stack([np.concatenate([order, zero]), np.concatenate([zero, order**2])])
        return np.asarray(scipy.linalg.block_diag(1.0, scipy.linalg.null_space(conditions)))


@lru_cache(maxsize=BASES_KEPT)
def _series(
    t: bytes, horizon: float, harmonics: int, order: int
) -> Float[ndarray, "samples series"]:
    """Derivatives of 1, sin(k w t) and cos(k w t) at the instants whose bytes are `t`."""
    orders = np.arange(1, harmonics + 1) * (2 * np.pi / horizon)
    angle = np.frombuffer(t)[:, None] * orders
    sine, cosine = np.sin(angle), np.cos(angle)
    turned = [(sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine)][order % 4]
    constant = np.full((len(angle), 1), 1.0 if order == 0 else 0.0)
    series = np.concatenate([constant, *(x * orders**order for x in turned)], axis=1)
    series.flags.writeable = False
    return series
