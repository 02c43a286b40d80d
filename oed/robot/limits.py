"""Limits of position, velocity, acceleration, jerk and torque, joint by joint."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.robot.joint_sum import JointSum

Bounds = Sequence[float] | Float[ndarray, " joints"]
LIMITED = ("position", "velocity", "acceleration", "torque", "jerk")


@dataclass(frozen=True)
class JointLimits:
    """What each joint may do; infinite where nothing is known.

    Attributes:
        position: (n, 2) lower and upper bound [rad or m].
        velocity: (n, 2) lower and upper bound [rad/s or m/s].
        acceleration: (n, 2) lower and upper bound [rad/s^2 or m/s^2].
        torque: (n, 2) lower and upper bound [N m or N].
        jerk: (n, 2) lower and upper bound [rad/s^3 or m/s^3].
        sums: Bounds on sums of positions over the joints.

    Raises:
        ValueError: If a lower bound is not below its upper bound.
    """

    position: Float[ndarray, "joints 2"]
    velocity: Float[ndarray, "joints 2"]
    acceleration: Float[ndarray, "joints 2"]
    torque: Float[ndarray, "joints 2"]
    jerk: Float[ndarray, "joints 2"]
    sums: tuple[JointSum, ...] = ()

    def __post_init__(self) -> None:
        for kind in LIMITED:
            bounds = getattr(self, kind)
            wrong = ~(bounds[:, 0] < bounds[:, 1])
            if wrong.any():
                joint = int(np.flatnonzero(wrong)[0])
                raise ValueError(
                    f"{kind} limit of joint {joint + 1}: lower {bounds[joint, 0]:g} "
                    f"is not below upper {bounds[joint, 1]:g}"
                )
        for each in self.sums:
            if len(each.factors) != len(self.position):
                raise ValueError(
                    f"a sum of {len(each.factors)} positions, limits of {len(self.position)} joints"
                )

    @classmethod
    def unlimited(cls, joints: int) -> JointLimits:
        """No limit on any of `joints` joints."""
        free = np.tile([-np.inf, np.inf], (joints, 1))
        return cls(free, free.copy(), free.copy(), free.copy(), free.copy())

    @classmethod
    def symmetric(
        cls,
        position: Bounds,
        velocity: Bounds | None = None,
        acceleration: Bounds | None = None,
        torque: Bounds | None = None,
        jerk: Bounds | None = None,
    ) -> JointLimits:
        """Limits |x| <= bound, one bound (n,) a joint; None leaves that kind free."""
        bounds = {
            "position": position,
            "velocity": velocity,
            "acceleration": acceleration,
            "torque": torque,
            "jerk": jerk,
        }
        given = {kind: _both_sides(bound) for kind, bound in bounds.items() if bound is not None}
        return cls.unlimited(len(given["position"])).with_(**given)

    def with_(self, **bounds: Float[ndarray, "joints 2"]) -> JointLimits:
        """These limits with some kinds replaced by (n, 2) arrays."""
        given: dict[str, Any] = {k: np.asarray(bound, dtype=float) for k, bound in bounds.items()}
        return dataclasses.replace(self, **given)

    def with_sums(self, more: Sequence[JointSum]) -> JointLimits:
        """These limits with further bounds on sums of positions."""
        return dataclasses.replace(self, sums=(*self.sums, *more))

    @property
    def sum_factors(self) -> Float[ndarray, "sums joints"]:
        """Factors of the joints in each sum."""
        return np.array([each.factors for each in self.sums]).reshape(-1, len(self.position))

    @property
    def sum_bounds(self) -> Float[ndarray, "sums 2"]:
        """Lower and upper bound of each sum [rad or m]."""
        return np.array([(each.lower, each.upper) for each in self.sums]).reshape(-1, 2)

    def slower(self, share: float) -> JointLimits:
        """These limits with a share of the velocity and acceleration that they allow."""
        return self.with_(velocity=share * self.velocity, acceleration=share * self.acceleration)


def _both_sides(bound: Bounds) -> Float[ndarray, "joints 2"]:
    upper = np.asarray(bound, dtype=float)
    return np.stack([-upper, upper], axis=1)
