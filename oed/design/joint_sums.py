"""Sums of joint positions: their course as that of a joint, and where there is room for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.optimize import linprog

from oed.design.trajectories import TrajectoryClass
from oed.robot import JointLimits


@dataclass(frozen=True, eq=False)
class JointSums:
    """Weighted sums over the joints of a class of motions; each stands for a joint.

    Attributes:
        trajectory: The class.
        factors: (c, n) of the joints in each sum.
    """

    trajectory: TrajectoryClass
    factors: Float[ndarray, "sums joints"]

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """As of the class."""
        return self.trajectory.breakpoints

    def derivative(
        self, z: Float[ndarray, " size"], t: Float[ndarray, " samples"], order: int
    ) -> Float[ndarray, "samples sums"]:
        """Exact time derivative of the sums, of any order from 0."""
        return self.trajectory.derivative(z, t, order) @ self.factors.T

    def derivative_bound(self, z: Float[ndarray, " size"], order: int) -> Float[ndarray, " sums"]:
        """An upper bound on |`derivative`| at all t; for order 0 on |sum - centre|."""
        return np.abs(self.factors) @ self.trajectory.derivative_bound(z, order)

    def bernstein(
        self, z: Float[ndarray, " size"], order: int
    ) -> Float[ndarray, "pieces coefficients sums"] | None:
        """`derivative` as polynomials between breakpoints, where joints are."""
        pieces = self.trajectory.bernstein(z, order)
        return None if pieces is None else pieces @ self.factors.T

    def centre(self, z: Float[ndarray, " size"]) -> Float[ndarray, " sums"]:
        """Value about which each sum moves."""
        return self.factors @ self.trajectory.centre(z)


def roomiest_posture(limits: JointLimits) -> Float[ndarray, " joints"]:
    """The posture as far from all bounds of positions and their sums as any, in half ranges.

    Mid-range where no sum is bounded.

    Raises:
        ValueError: If no posture is strictly within all of them.
    """
    if not limits.sums:
        return limits.position.mean(axis=1)
    factors = np.vstack([np.eye(len(limits.position)), limits.sum_factors])
    bounds = np.vstack([limits.position, limits.sum_bounds])
    half = np.diff(bounds, axis=1)[:, 0] / 2
    half = np.where(np.isfinite(half), half, 1.0)[:, None]  # a lone side: by itself, in rad
    sides = np.vstack([np.hstack([factors, half]), np.hstack([-factors, half])])
    room = np.concatenate([bounds[:, 1], -bounds[:, 0]])
    is_bound = np.isfinite(room)
    cost = np.append(np.zeros(len(limits.position)), -1.0)
    free = [(None, None)] * len(limits.position)
    found = linprog(cost, sides[is_bound], room[is_bound], bounds=[*free, (None, 1.0)])
    if found.x is None or found.x[-1] <= 0.0:
        raise ValueError("no posture is within the limits of positions and of their sums")
    return found.x[:-1]
