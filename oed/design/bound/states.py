"""The states that a motion within its limits can be in."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.robot import JointLimits


@dataclass(frozen=True)
class ViableStates:
    """States from which a periodic motion can have come, and can go on, within its limits.

    A joint at q with velocity v > 0 must be able to stop before q_max, and must have been able
    to reach v since q_min: v^2 <= 2 |ddq_min| (q_max - q) and v^2 <= 2 ddq_max (q - q_min); for
    v < 0 the same two follow. So given v, q lies in an interval, and (v, s) with s from 0 to 1
    along that interval describes the set by a box: coordinates x = (v_1, s_1, ..., v_n, s_n).

    Accelerations are in a box. What is maximised over it is convex in the acceleration, so
    that its vertices suffice.

    Attributes:
        limits: Finite position and acceleration limits of every joint.

    Raises:
        ValueError: If one is infinite, or a velocity range is not symmetric about zero.
    """

    limits: JointLimits

    def __post_init__(self) -> None:
        for kind in ("position", "acceleration"):
            if not np.isfinite(getattr(self.limits, kind)).all():
                raise ValueError(f"a bound over all states needs finite {kind} limits")
        if not np.allclose(self.limits.velocity[:, 0], -self.limits.velocity[:, 1]):
            raise ValueError("velocity limits must be symmetric about zero")

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.limits.position)

    @cached_property
    def fastest(self) -> Float[ndarray, " joints"]:
        """Largest speed of each joint: its limit, or where both parabolas meet."""
        room = np.diff(self.limits.position, axis=1)[:, 0]
        down, up = np.abs(self.limits.acceleration).T
        return np.minimum(self.limits.velocity[:, 1], np.sqrt(2 * room / (1 / up + 1 / down)))

    @cached_property
    def longest_return(self) -> float:
        """Time within which the arm gets from any of these states to any other [s].

        Every joint brakes to rest, moves from rest to rest through at most its whole range, and
        speeds up to where it is wanted; a joint that is early waits at rest.
        """
        room = np.diff(self.limits.position, axis=1)[:, 0]
        down, up = np.abs(self.limits.acceleration).T
        both = 1 / up + 1 / down  # seconds of speeding up and of braking for each rad/s
        speed = np.minimum(self.limits.velocity[:, 1], np.sqrt(2 * room / both))
        transfer = room / speed + speed * both / 2
        change = self.fastest / np.minimum(down, up)
        return float((2 * change + transfer).max())

    @cached_property
    def box(self) -> Float[ndarray, "coordinates 2"]:
        """Bounds of the coordinates x."""
        speed = np.stack([-self.fastest, self.fastest], axis=1)
        return np.stack([speed, np.tile([0.0, 1.0], (self.joints, 1))], axis=1).reshape(-1, 2)

    @cached_property
    def vertices(self) -> Float[ndarray, "vertices joints"]:
        """All 2^n corners of the accelerations' box."""
        return np.array(list(itertools.product(*self.limits.acceleration)))

    def motion(
        self, x: Float[ndarray, "states coordinates"], ddq: Float[ndarray, "states joints"]
    ) -> Motion:
        """The states as samples of a motion."""
        v, s = x[:, 0::2], x[:, 1::2]
        down, up = np.abs(self.limits.acceleration).T
        low = self.limits.position[:, 0] + v**2 / (2 * up)
        high = self.limits.position[:, 1] - v**2 / (2 * down)
        return Motion(np.zeros(len(x)), low + s * (high - low), v, ddq)

    def symbolic(self, x: casadi.SX) -> tuple[casadi.SX, casadi.SX]:
        """Position and velocity as expressions of the coordinates."""
        down, up = np.abs(self.limits.acceleration).T
        q, v = [], []
        for j in range(self.joints):
            velocity, s = x[2 * j], x[2 * j + 1]
            lower, upper = self.limits.position[j]
            low = lower + velocity**2 * (0.5 / up[j])
            high = upper - velocity**2 * (0.5 / down[j])
            q.append(low + s * (high - low))
            v.append(velocity)
        return casadi.vertcat(*q), casadi.vertcat(*v)

    def sample(
        self, count: int, rng: np.random.Generator
    ) -> tuple[Float[ndarray, "states coordinates"], Float[ndarray, "states joints"]]:
        """Random coordinates, every third at an end of its range, and random vertices."""
        x = rng.uniform(self.box[:, 0], self.box[:, 1], (count, len(self.box)))
        ends = self.box[np.arange(len(self.box)), rng.integers(0, 2, x.shape)]
        x = np.where(rng.random(x.shape) < 1 / 3, ends, x)
        return x, self.vertices[rng.integers(0, len(self.vertices), count)]
