"""Sampled joint motion."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from hashlib import blake2b
from itertools import chain, pairwise

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.interpolate import CubicHermiteSpline, make_interp_spline

from oed.robot import Robot

Curve = Callable[[Float[ndarray, " times"]], Float[ndarray, "times joints"]]
Components = tuple[Float[ndarray, " samples"], ...]

REMEMBERED = 2  # motions made of one: as seen through the measurement of a model, and of another
STRIDE = 8  # samples that a motion's fingerprint leaves out
UNBOUNDED_RANGE = np.pi  # [rad or m] half width used where a joint has no position limit
UNBOUNDED_RATE = 3.0  # [rad/s] or [rad/s^2], where a joint has no such limit


def follow_one_another(times: Sequence[Float[ndarray, " _"]]) -> bool:
    """Whether no two of several stretches of increasing time overlap, in whatever order."""
    spans = sorted((float(t[0]), float(t[-1])) for t in times)
    return all(later[0] > earlier[1] for earlier, later in pairwise(spans))


@dataclass(frozen=True)
class Motion:
    """Joint positions, velocities and accelerations at N instants.

    Attributes:
        t: (N,) time [s].
        q: (N, n) position [rad or m].
        dq: (N, n) velocity [rad/s or m/s].
        ddq: (N, n) acceleration [rad/s^2 or m/s^2].
        averaged: Whether a sample stands for the mean over its step, not for its instant: a
            velocity that changes its sign between two samples then does so in part at both.
        noise: One-sided spectral density of each joint's position noise, white [rad^2/Hz]; None
            of a motion that was not measured.
        temperature: (N, n) of each joint or its motor [degrees Celsius]; None where none was
            measured.
    """

    t: Float[ndarray, " samples"]
    q: Float[ndarray, "samples joints"]
    dq: Float[ndarray, "samples joints"]
    ddq: Float[ndarray, "samples joints"]
    averaged: bool = field(default=False, kw_only=True)
    noise: tuple[float, ...] | None = field(default=None, kw_only=True)
    temperature: Float[ndarray, "samples joints"] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        shapes = {"q": self.q.shape, "dq": self.dq.shape, "ddq": self.ddq.shape}
        if self.temperature is not None:
            shapes["temperature"] = self.temperature.shape
        if len(set(shapes.values())) != 1 or len(self.t) != len(self.q):
            raise ValueError(f"shapes disagree: t {self.t.shape}, {shapes}")

    def __len__(self) -> int:
        return len(self.t)

    @cached_property
    def components(self) -> tuple[Components, Components, Components]:
        """q, dq and ddq as contiguous (N,) arrays, one a joint."""
        q, dq, ddq = (tuple(np.ascontiguousarray(x.T)) for x in (self.q, self.dq, self.ddq))
        return q, dq, ddq

    @cached_property
    def curves(self) -> tuple[Curve, Curve, Curve]:
        """q, dq and ddq between the samples, cubic; the first two with the slopes that they have."""
        return (
            CubicHermiteSpline(self.t, self.q, self.dq),
            CubicHermiteSpline(self.t, self.dq, self.ddq),
            make_interp_spline(self.t, self.ddq, k=3),
        )

    @cached_property
    def signs(self) -> dict[tuple[int, float], Float[ndarray, " samples"]]:
        """Mean signs that were asked for, by the identity of a joint's velocity and the width."""
        return {}

    @cached_property
    def changes(self) -> dict[Hashable, Motion]:
        """Motions that were made of this one, by what made them."""
        return {}

    def changed(self, by: Hashable, make: Callable[[], Motion]) -> Motion:
        """A motion made of this one, remembered: a scan asks for the same one at each trial value.

        Args:
            by: What makes it, equal where the result is.
            make: Works it out.
        """
        if by not in self.changes:
            if len(self.changes) >= REMEMBERED:
                self.changes.clear()
            self.changes[by] = make()
        return self.changes[by]

    @cached_property
    def fingerprint(self) -> bytes:
        """What tells one sampled motion from another.

        Every few samples, since motions that differ do so nearly everywhere.
        """
        digest = blake2b(repr((self.averaged, self.noise)).encode(), digest_size=16)
        warmth = () if self.temperature is None else self.temperature.T
        for component in (self.t, *chain(*self.components), *warmth):
            digest.update(component[::STRIDE].tobytes())
            digest.update(component[-1:].tobytes())
        return digest.digest()

    def __getitem__(self, samples: slice | ndarray) -> Motion:
        return dataclasses.replace(
            self,
            t=self.t[samples],
            q=self.q[samples],
            dq=self.dq[samples],
            ddq=self.ddq[samples],
            temperature=None if self.temperature is None else self.temperature[samples],
        )

    @classmethod
    def concatenate(cls, motions: Sequence[Motion]) -> Motion:
        """One motion after another; time is kept as it is."""
        return cls(
            *(np.concatenate([getattr(m, f) for m in motions]) for f in ("t", "q", "dq", "ddq"))
        )


def with_joint(motion: Motion, joint: int, states: Sequence[Float[ndarray, " samples"]]) -> Motion:
    """The motion with other q, dq and ddq of one joint."""
    changed = [motion.q.copy(), motion.dq.copy(), motion.ddq.copy()]
    for whole, own in zip(changed, states, strict=True):
        whole[:, joint] = own
    q, dq, ddq = changed
    return dataclasses.replace(motion, q=q, dq=dq, ddq=ddq)


def random_motion(robot: Robot, samples: int, rng: np.random.Generator) -> Motion:
    """Independent random states within the robot's limits: no trajectory, one state a row.

    Args:
        robot: Its limits bound the states; a joint without one gets a round figure.
        samples: Number of states N.
        rng: Source of every draw.
    """

    def draw(
        bounds: Float[ndarray, "joints 2"], default: float
    ) -> Float[ndarray, "samples joints"]:
        lower = np.where(np.isfinite(bounds[:, 0]), bounds[:, 0], -default)
        upper = np.where(np.isfinite(bounds[:, 1]), bounds[:, 1], default)
        return rng.uniform(lower, upper, (samples, robot.n))

    limits = robot.limits
    return Motion(
        t=np.arange(samples, dtype=float),
        q=draw(limits.position, UNBOUNDED_RANGE),
        dq=draw(limits.velocity, UNBOUNDED_RATE),
        ddq=draw(limits.acceleration, UNBOUNDED_RATE),
    )
