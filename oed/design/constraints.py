"""Kinematic limits at chosen instants, as inequalities with sparse derivatives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse
from jaxtyping import Float
from numpy import ndarray

from oed.design.limits import KINEMATIC
from oed.design.trajectories import TrajectoryClass
from oed.robot import JointLimits


@dataclass(frozen=True, eq=False)
class TrustRegion:
    """How far positions may be from those of a motion.

    Attributes:
        z: (size,) the motion.
        step: [rad or m]
    """

    z: Float[ndarray, " size"]
    step: float


@dataclass(frozen=True)
class LimitConstraints:
    """Sampled limits of a class of motions, each relative to half its range.

    Rows: kind after kind, within it instant after instant, within it joint after joint; each
    is a signal less the middle of its range, in half ranges, so that it is kept within
    `lower` and `upper`, mostly -1 and 1. A limit that is infinite on both sides, or that other
    limits or the box imply, has no rows. Sums of positions follow, as they are, sum after sum.

    Attributes:
        trajectory: The class.
        limits: Of the joints.
        instants: (K,) where they are looked at [s].
        trust: Keeps positions at the instants near those of a motion; None for no such bound.
    """

    trajectory: TrajectoryClass
    limits: JointLimits
    instants: Float[ndarray, " samples"]
    trust: TrustRegion | None = None

    @property
    def count(self) -> int:
        """Number of rows."""
        return self._own_count + len(self.limits.sums) * len(self.instants)

    @cached_property
    def lower(self) -> Float[ndarray, " constraints"]:
        """Lower bounds of the rows, -inf where there is none."""
        own = [self._bound(kind, kind.lower, np.maximum, -1.0) for kind in self._kinds]
        return _joined([*own, np.repeat(self.limits.sum_bounds[:, 0], len(self.instants))])

    @cached_property
    def upper(self) -> Float[ndarray, " constraints"]:
        """Upper bounds of the rows, inf where there is none."""
        own = [self._bound(kind, kind.upper, np.minimum, 1.0) for kind in self._kinds]
        return _joined([*own, np.repeat(self.limits.sum_bounds[:, 1], len(self.instants))])

    def values(self, z: Float[ndarray, " size"]) -> Float[ndarray, " constraints"]:
        """The rows, within `lower` and `upper` where the limits are kept."""
        parts = []
        for kind in self._kinds:
            signal = self.trajectory.derivative(z, self.instants, kind.order)[:, kind.joints]
            parts.append(((signal - kind.middle) / kind.scale).reshape(-1))
        if self.limits.sums:
            position = self.trajectory.derivative(z, self.instants, 0)
            parts.append((self.limits.sum_factors @ position.T).reshape(-1))
        return _joined(parts)

    def jacobian_values(self, z: Float[ndarray, " size"]) -> Float[ndarray, " nonzeros"]:
        """Entries of the Jacobian in the order of `rows` and `columns`."""
        parts = []
        for kind in self._kinds:
            slopes = self.trajectory.sensitivity(z, self.instants, kind.order)[:, kind.joints]
            parts.append((slopes / kind.scale[:, None]).reshape(-1))
        if self.limits.sums:
            slopes = self.trajectory.sensitivity(z, self.instants, 0)
            factors = self.limits.sum_factors
            parts.append((factors[:, None, :, None] * slopes).reshape(-1))
        return _joined(parts)

    def jacobian(self, z: Float[ndarray, " size"]) -> scipy.sparse.csr_matrix:
        """dg/dz."""
        shape = (self.count, self.trajectory.size)
        entries = (self.jacobian_values(z), (self.rows, self.columns))
        return scipy.sparse.csr_matrix(entries, shape=shape)

    def room(self, z: Float[ndarray, " size"]) -> Float[ndarray, " sides"]:
        """Distance to every finite bound, lower ones first; not negative where they are kept."""
        values, (below, above) = self.values(z), self._bounded
        return np.concatenate([(values - self.lower)[below], (self.upper - values)[above]])

    def room_jacobian(self, z: Float[ndarray, " size"]) -> Float[ndarray, "sides size"]:
        """D room / dz, zeros written out."""
        whole = self.jacobian(z).toarray()
        below, above = self._bounded
        return np.concatenate([whole[below], -whole[above]])

    @cached_property
    def rows(self) -> ndarray:
        """Row of each structural nonzero of the Jacobian."""
        own = np.arange(self._own_count)
        sums = np.arange(self._own_count, self.count)
        per_joint = self.trajectory.variables.shape[1]
        return np.concatenate([np.repeat(own, per_joint), np.repeat(sums, self.trajectory.size)])

    @cached_property
    def columns(self) -> ndarray:
        """Column of each structural nonzero of the Jacobian."""
        variables = self.trajectory.variables
        own = [
            np.tile(variables[kind.joints].reshape(-1), len(self.instants)) for kind in self._kinds
        ]
        everything = variables.reshape(-1)
        sums = np.tile(everything, len(self.limits.sums) * len(self.instants))
        return np.concatenate([np.zeros(0, dtype=int), *own, sums])

    @cached_property
    def _bounded(self) -> tuple[ndarray, ndarray]:
        """Which rows have a lower bound, and which an upper one."""
        return np.isfinite(self.lower), np.isfinite(self.upper)

    @property
    def _own_count(self) -> int:
        """Rows of single joints."""
        return len(self.instants) * sum(len(kind.joints) for kind in self._kinds)

    def _bound(
        self, kind: _Kind, bound: ndarray, tighter: Callable[..., ndarray], side: float
    ) -> Float[ndarray, " rows"]:
        """Of the rows of a kind, those of position within the trust region too."""
        tiled = np.tile(bound, len(self.instants))
        if self.trust is None or kind.order != 0:
            return tiled
        q = self.trajectory.derivative(self.trust.z, self.instants, 0)[:, kind.joints]
        near = (q + side * self.trust.step - kind.middle) / kind.scale
        return tighter(tiled, near.reshape(-1))

    @cached_property
    def _kinds(self) -> list[_Kind]:
        if self.trajectory.box_keeps_limits and not np.isfinite(self.limits.jerk).any():
            return []
        implied = implied_velocity(self.limits, self.trajectory.horizon)
        kinds = []
        for order, name in enumerate(KINEMATIC):
            limit = getattr(self.limits, name)
            is_needed = np.isfinite(limit).any(axis=1)
            if name == "velocity":
                is_needed &= ~implied
            if is_needed.any():
                kinds.append(_kind(order, np.flatnonzero(is_needed), limit[is_needed]))
        return kinds


@dataclass(frozen=True, eq=False)
class _Kind:
    """The limited joints of one derivative of position, and their bounds in half ranges."""

    order: int
    joints: ndarray
    middle: ndarray
    scale: ndarray
    lower: ndarray
    upper: ndarray


def _joined(parts: Sequence[ndarray]) -> ndarray:
    return np.concatenate(parts) if parts else np.zeros(0)


def _kind(order: int, joints: ndarray, limit: Float[ndarray, "limited 2"]) -> _Kind:
    is_two_sided = np.isfinite(limit).all(axis=1)
    known = np.where(np.isfinite(limit), limit, 0.0)  # a lone side is relative to itself
    middle = np.where(is_two_sided, known.mean(axis=1), 0.0)
    half = np.abs(np.diff(known, axis=1)[:, 0])
    scale = np.where(is_two_sided, half / 2, np.where(half > 0, half, 1.0))
    lower, upper = ((limit - middle[:, None]) / scale[:, None]).T
    return _Kind(order, joints, middle, scale, lower, upper)


def implied_velocity(limits: JointLimits, horizon: float) -> Float[ndarray, " joints"] | ndarray:
    """Joints whose velocity limit follows from those of position and acceleration.

    A joint faster than sqrt(2 alpha R) runs out of its range R before it can stop, forward or
    backward in time, if half the horizon is long enough for that stop.
    """
    room = np.diff(limits.position, axis=1)[:, 0]
    acceleration = np.abs(limits.acceleration).max(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        fastest = np.sqrt(2 * acceleration * room)
        stop = fastest / acceleration
    slowest_limit = np.abs(limits.velocity).min(axis=1)
    return np.isfinite(fastest) & (slowest_limit >= fastest) & (stop <= horizon / 2)
