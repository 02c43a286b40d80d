"""Finite Fourier series of one fundamental: periodic, and linear in its coefficients.

Swevers et al. 1997, "Optimal robot excitation and identification".
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy.linalg
from jaxtyping import Float, Int
from numpy import ndarray

from oed.design.trajectories.trajectory import TrajectoryClass
from oed.robot import JointLimits

BASES_KEPT = 32  # the criterion, the limits and the reports each have their instants


@dataclass(frozen=True)
class FourierClass(TrajectoryClass):
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
    is_linear = True
    has_offset = True

    def __post_init__(self) -> None:
        if not np.isfinite(self.limits.position).all():
            raise ValueError("a Fourier class needs finite position limits of every joint")
        if self.at_rest and self.harmonics < 2:
            raise ValueError(f"{self.harmonics=} harmonic cannot start and end at rest")

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.limits.position)

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

    @cached_property
    def variables(self) -> Int[ndarray, "joints own"]:  # pyright: ignore[reportIncompatibleMethodOverride]  # a property too, and cached
        """Joint after joint."""
        own = self._subspace.shape[1]
        return np.arange(self.joints * own).reshape(self.joints, own)

    def derivative(
        self, z: Float[ndarray, " size"], t: Float[ndarray, " samples"], order: int
    ) -> Float[ndarray, "samples joints"]:
        """Exact time derivative of position."""
        return self.basis(t, order) @ np.asarray(z, dtype=float).reshape(self.joints, -1).T

    def sensitivity(
        self,
        z: Float[ndarray, " size"],  # noqa: ARG002  # the same for every z
        t: Float[ndarray, " samples"],
        order: int,
    ) -> Float[ndarray, "samples joints own"]:
        """The basis, the same for every joint and z."""
        basis = self.basis(t, order)
        return np.broadcast_to(basis[:, None, :], (len(t), self.joints, basis.shape[1]))

    def basis(self, t: Float[ndarray, " samples"], order: int) -> Float[ndarray, "samples own"]:
        """Derivative of position by a joint's own variables."""
        series = _series(
            np.ascontiguousarray(t, dtype=float).tobytes(), self.horizon, self.harmonics, order
        )
        return series @ self._subspace if self.at_rest else series

    def pull_back(
        self,
        z: Float[ndarray, " size"],  # noqa: ARG002  # the same for every z
        t: Float[ndarray, " samples"],
        adjoints: tuple[Float[ndarray, "samples joints"], ...],
    ) -> Float[ndarray, " size"]:
        """Gradient by z, one matrix product an order."""
        parts = [adjoint.T @ self.basis(t, order) for order, adjoint in enumerate(adjoints)]
        return sum(parts[1:], parts[0]).reshape(-1)

    def derivative_bound(self, z: Float[ndarray, " size"], order: int) -> Float[ndarray, " joints"]:
        """sum_k of the harmonics' magnitudes times (k w)^order."""
        _, sines, cosines = self._parts(z)
        orders = np.arange(1, self.harmonics + 1) * self.fundamental
        return np.hypot(sines, cosines) @ orders**order

    def centre(self, z: Float[ndarray, " size"]) -> Float[ndarray, " joints"]:
        """The offsets."""
        return np.asarray(z, dtype=float).reshape(self.joints, -1)[:, 0]

    def shrink(
        self, z: Float[ndarray, " size"], factors: Float[ndarray, " joints"]
    ) -> Float[ndarray, " size"]:
        """All but the offsets multiplied."""
        own = np.array(z, dtype=float).reshape(self.joints, -1)
        own[:, 1:] *= factors[:, None]
        return own.reshape(-1)

    def shift(
        self, z: Float[ndarray, " size"], distance: Float[ndarray, " joints"]
    ) -> Float[ndarray, " size"]:
        """Offsets moved."""
        own = np.array(z, dtype=float).reshape(self.joints, -1)
        own[:, 0] += distance
        return own.reshape(-1)

    def describe(self, z: Float[ndarray, " size"]) -> dict[str, ndarray]:
        """Offset (n,), sine and cosine coefficients (n, W)."""
        offset, sines, cosines = self._parts(z)
        fundamental = np.array(self.fundamental)
        return {"offset": offset, "sine": sines, "cosine": cosines, "fundamental": fundamental}

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
