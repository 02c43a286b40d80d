"""Periodic splines on equally spaced knots; of degree 3 their acceleration is piecewise linear.

With degree 3 this is direct collocation with piecewise-linear controls: the acceleration at each
knot is free, velocity and position are its exact integrals. Limits of acceleration can then be
used all the time, which few harmonics cannot.

C. de Boor, "A Practical Guide to Splines", chapters IX-XI.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy.linalg
import scipy.special
from jaxtyping import Float
from numpy import ndarray
from scipy.interpolate import BSpline

from oed.design.trajectories.linear import LinearClass
from oed.robot import JointLimits

BASES_KEPT = 32  # the criterion, the limits and the reports each have their instants
LOWEST_DEGREE, HIGHEST_DEGREE = 3, 7  # acceleration is continuous from 3 on
MOST_SEGMENTS = 400  # forty a second of a motion of ten
# Share of its modes that a random motion uses. The others are too fast for the range of
# positions: of 40 segments the slow quarter bends as five harmonics do.
DRAWN_MODES = 0.25


@dataclass(frozen=True)
class SplineClass(LinearClass):
    """q_j(t) = sum_i c_ji B(t / h - i), B the cardinal B-spline, h = horizon / segments.

    A joint's control points c repeat after one period, K = `segments` of them. Its own variables
    are their mean, which is that of the position, and the amplitudes of their second
    differences, h^2 times the acceleration's control points, in orthonormal modes from slow to
    fast. In these the criterion bends about equally in all directions, unlike in c.

    Attributes:
        horizon: One period [s].
        limits: Position, and velocity and acceleration where there are any, give the box.
        segments: K.
        degree: Of the polynomials between knots.
        at_rest: Whether the motion starts and ends at rest: the control points that act there
            are equal, so that all derivatives but the highest are zero.
    """

    horizon: float
    limits: JointLimits
    segments: int = 40
    degree: int = 3
    at_rest: bool = False
    name = "spline"
    is_periodic = True

    def __post_init__(self) -> None:
        if not np.isfinite(self.limits.position).all():
            raise ValueError("a spline class needs finite position limits of every joint")
        if not LOWEST_DEGREE <= self.degree <= HIGHEST_DEGREE:
            raise ValueError(f"{self.degree=} is not within {LOWEST_DEGREE} ... {HIGHEST_DEGREE}")
        if not 2 * self.degree < self.segments <= MOST_SEGMENTS:
            raise ValueError(
                f"{self.segments=} is not above twice the degree and at most {MOST_SEGMENTS}"
            )

    @property
    def step(self) -> float:
        """Time between knots h [s]."""
        return self.horizon / self.segments

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The knots."""
        return tuple(np.linspace(0.0, self.horizon, self.segments + 1).tolist())

    @property
    def own(self) -> int:
        """Number of each joint's own variables."""
        return self._control.shape[1]

    def basis(self, t: Float[ndarray, " samples"], order: int) -> Float[ndarray, "samples own"]:
        """Derivative of position by a joint's own variables."""
        times = np.ascontiguousarray(t, dtype=float).tobytes()
        return _bumps(times, self.horizon, self.segments, self.degree, order) @ self._control

    def draw(self, rng: np.random.Generator) -> Float[ndarray, " size"]:
        """A random point with slow modes only."""
        own = super().draw(rng).reshape(self.joints, -1)
        own[:, 1 + int(np.ceil(DRAWN_MODES * self.own)) :] = 0.0
        return own.reshape(-1)

    def derivative_bound(self, z: Float[ndarray, " size"], order: int) -> Float[ndarray, " joints"]:
        """The largest control point of the derivative; of position, from the mean."""
        if order > self.degree:
            return np.zeros(self.joints)
        control = self._of_derivative(z, order)
        return np.abs(control - self.centre(z) if order == 0 else control).max(axis=0)

    def bernstein(
        self, z: Float[ndarray, " size"], order: int
    ) -> Float[ndarray, "pieces coefficients joints"]:
        """Of each segment."""
        if order > self.degree:
            return np.zeros((self.segments, 1, self.joints))
        degree = self.degree - order
        control = self._of_derivative(z, order)
        acting = np.arange(self.segments)[:, None] + np.arange(degree + 1)
        return np.einsum("cb,kbj->kcj", _to_bernstein(degree), control[acting % self.segments])

    def limit_instants(self, count: int) -> Float[ndarray, " samples"]:
        """The knots, where extrema of piecewise-linear acceleration are, and some between."""
        parts = int(np.ceil(count / self.segments))
        return np.linspace(0.0, self.horizon, self.segments * parts + 1)

    def slower(self, scale: float) -> SplineClass:
        """The same control points over a longer period."""
        return dataclasses.replace(self, horizon=self.horizon / scale)

    def describe(self, z: Float[ndarray, " size"]) -> dict[str, ndarray]:
        """Control points (n, K) [rad or m] and the degree."""
        return {"control_points": self._of_derivative(z, 0).T, "degree": np.array(self.degree)}

    @classmethod
    def restore(
        cls, horizon: float, limits: JointLimits, coefficients: Mapping[str, ndarray]
    ) -> tuple[SplineClass, Float[ndarray, " size"]]:
        """The spline of these control points, whether or not it is at rest at its ends."""
        control = coefficients.get("control_points", np.empty(0))
        degree, joints = coefficients.get("degree", np.empty(0)), len(limits.position)
        if control.ndim != 2 or len(control) != joints or degree.shape != ():
            raise ValueError(
                f"control_points and degree have shapes {control.shape} and {degree.shape}, not "
                f"those of a spline of {joints} joints"
            )
        spline = cls(horizon, limits, control.shape[1], int(degree))
        return spline, np.linalg.lstsq(spline._control, control.T, rcond=None)[0].T.reshape(-1)

    def _of_derivative(
        self, z: Float[ndarray, " size"], order: int
    ) -> Float[ndarray, "segments joints"]:
        """Control points of a derivative [rad/s^order]; on segment k those from k on act."""
        control = self._control @ np.asarray(z, dtype=float).reshape(self.joints, -1).T
        for _ in range(order):
            control = (np.roll(control, -1, axis=0) - control) / self.step
        return control

    @cached_property
    def _control(self) -> Float[ndarray, "segments own"]:
        """Control points by a joint's own variables."""
        count = self.segments
        free = np.eye(count)
        if self.at_rest:  # those that act at time 0 are one
            free = np.concatenate(
                [free[:, : self.degree].sum(axis=1)[:, None], free[:, self.degree :]], axis=1
            )
        balanced = free @ scipy.linalg.null_space(free.sum(axis=0)[None])  # mean zero
        differences = _differences(count)
        _, sizes, modes = np.linalg.svd(differences @ differences @ balanced, full_matrices=False)
        slow_first = np.argsort(sizes)
        by_mode = balanced @ (modes.T / sizes)[:, slow_first]
        return np.concatenate([np.ones((count, 1)), by_mode], axis=1)


def _differences(count: int) -> Float[ndarray, "count count"]:
    """Of consecutive control points of a period."""
    return np.roll(np.eye(count), 1, axis=1) - np.eye(count)


def _acting(x: Float[ndarray, " samples"], degree: int) -> Float[ndarray, "samples acting"]:
    """The `degree` + 1 B-splines that are not zero on the segment from 0 to 1."""
    knots = np.arange(-degree, degree + 2, dtype=float)
    return BSpline(knots, np.eye(degree + 1), degree)(x)


@lru_cache(maxsize=HIGHEST_DEGREE + 1)
def _to_bernstein(degree: int) -> Float[ndarray, "coefficients acting"]:
    """Bernstein coefficients on a segment by the control points that act there."""
    points = np.linspace(0.0, 1.0, degree + 1)
    bernstein = np.stack(
        [
            scipy.special.comb(degree, k) * points**k * (1 - points) ** (degree - k)
            for k in range(degree + 1)
        ],
        axis=1,
    )
    return np.linalg.solve(bernstein, _acting(points, degree))


@lru_cache(maxsize=BASES_KEPT)
def _bumps(
    t: bytes, horizon: float, segments: int, degree: int, order: int
) -> Float[ndarray, "samples segments"]:
    """Derivatives of position by the control points at the instants whose bytes are `t`."""
    times = np.frombuffer(t)
    if order > degree:
        return np.zeros((len(times), segments))
    step = horizon / segments
    knots = step * np.arange(-degree, segments + degree + 1)
    bumps = BSpline(knots, np.eye(segments + degree), degree)(times, nu=order)
    bumps[:, :degree] += bumps[:, segments:]  # the period closes
    bumps = bumps[:, :segments].copy()
    bumps.flags.writeable = False
    return bumps
