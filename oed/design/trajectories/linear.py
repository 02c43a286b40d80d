"""Motions that are linear in their variables, with one basis of functions for all joints."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.design.trajectories.trajectory import TrajectoryClass
from oed.robot import JointLimits

FITTED = 2000  # instants at which a sine is fitted, and the box is found


class LinearClass(TrajectoryClass):
    """q_j(t) = offset_j + sum_k z_jk b_k(t); z holds joint after joint, the offset first.

    A subclass says what the basis is and how far a motion can go; all else follows. It is a
    frozen dataclass with the fields `horizon` and `limits`. No b_k may be a polynomial of degree
    1 or less, so that acceleration determines all variables but the offset.

    Attributes:
        limits: Position, velocity and acceleration limits give the box.
    """

    is_linear = True
    has_offset = True

    limits: JointLimits

    @property
    @abstractmethod
    def own(self) -> int:
        """Number of each joint's own variables."""

    @abstractmethod
    def basis(self, t: Float[ndarray, " samples"], order: int) -> Float[ndarray, "samples own"]:
        """Derivative of position by a joint's own variables; that of order 0 begins with ones."""

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.limits.position)

    @cached_property
    def bounds(self) -> Float[ndarray, "size 2"]:  # pyright: ignore[reportIncompatibleMethodOverride]  # a property too, and cached
        """A box that cuts off no admissible motion.

        Each variable is a weighted sum of the position at many instants, and also one of the
        velocity and of the acceleration: the pseudo-inverse of the basis holds the weights. It is
        at most the sum of their magnitudes times the limit.
        """
        limits, t = self.limits, np.arange(FITTED) * (self.horizon / FITTED)
        reach = np.diff(limits.position, axis=1)[:, 0] / 2
        most = [reach, *(np.abs(x).max(axis=1) for x in (limits.velocity, limits.acceleration))]
        weights = [np.linalg.pinv(self.basis(t, order)) for order in range(3)]
        sides = [
            np.outer(limit, np.abs(weight[1:]).sum(axis=1))
            for limit, weight in zip(most, weights, strict=True)
        ]
        largest = np.min(sides, axis=0)
        lower = np.concatenate([limits.position[:, :1], -largest], axis=1)
        upper = np.concatenate([limits.position[:, 1:], largest], axis=1)
        return np.stack([lower.reshape(-1), upper.reshape(-1)], axis=1)

    @cached_property
    def variables(self) -> Int[ndarray, "joints own"]:  # pyright: ignore[reportIncompatibleMethodOverride]  # a property too, and cached
        """Joint after joint."""
        return np.arange(self.joints * self.own).reshape(self.joints, self.own)

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

    def pull_back(
        self,
        z: Float[ndarray, " size"],  # noqa: ARG002  # the same for every z
        t: Float[ndarray, " samples"],
        adjoints: tuple[Float[ndarray, "samples joints"], ...],
    ) -> Float[ndarray, " size"]:
        """Gradient by z, one matrix product an order."""
        parts = [adjoint.T @ self.basis(t, order) for order, adjoint in enumerate(adjoints)]
        return sum(parts[1:], parts[0]).reshape(-1)

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

    def swing(
        self,
        middle: Float[ndarray, " joints"],
        amplitude: Float[ndarray, " joints"],
        rate: Float[ndarray, " joints"],
    ) -> Float[ndarray, " size"] | None:
        """The nearest motion of the class, by least squares; whole cycles where it returns."""
        t = np.arange(FITTED) * (self.horizon / FITTED)
        if self.is_periodic:
            cycle = 2 * np.pi / self.horizon
            rate = cycle * np.maximum(1.0, np.round(rate / cycle))
        wave = amplitude * np.sin(t[:, None] * rate)
        own, *_ = np.linalg.lstsq(self.basis(t, 0), middle + wave, rcond=None)
        return own.T.reshape(-1)

    def with_limits(self, limits: JointLimits) -> LinearClass:
        """The same functions in the box of other limits."""
        return dataclasses.replace(self, limits=limits)  # pyright: ignore[reportArgumentType]  # every subclass is a dataclass
