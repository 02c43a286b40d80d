"""Kinematic limits at chosen instants, as inequalities with sparse derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse
from jaxtyping import Float
from numpy import ndarray

from oed.design.limits import KINEMATIC
from oed.design.trajectories import TrajectoryClass
from oed.robot import JointLimits


@dataclass(frozen=True)
class LimitConstraints:
    """Sampled limits of a class of motions, each relative to half its range.

    Rows: kind after kind, within it instant after instant, within it joint after joint; each
    is a signal less the middle of its range, in half ranges, so that it is kept within
    `lower` and `upper`, mostly -1 and 1. A limit that is infinite on both sides, or that other
    limits or the box imply, has no rows.

    Attributes:
        trajectory: The class.
        limits: Of the joints.
        instants: (K,) where they are looked at [s].
    """

    trajectory: TrajectoryClass
    limits: JointLimits
    instants: Float[ndarray, " samples"]

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.instants) * sum(len(kind.joints) for kind in self._kinds)

    @property
    def lower(self) -> Float[ndarray, " constraints"]:
        """Lower bounds of the rows, -inf where there is none."""
        return self._stack([kind.lower for kind in self._kinds])

    @property
    def upper(self) -> Float[ndarray, " constraints"]:
        """Upper bounds of the rows, inf where there is none."""
        return self._stack([kind.upper for kind in self._kinds])

    def values(self, z: Float[ndarray, " size"]) -> Float[ndarray, " constraints"]:
        """The rows, within `lower` and `upper` where the limits are kept."""
        parts = []
        for kind in self._kinds:
            signal = self.trajectory.derivative(z, self.instants, kind.order)[:, kind.joints]
            parts.append(((signal - kind.middle) / kind.scale).reshape(-1))
        return np.concatenate(parts) if parts else np.zeros(0)

    def jacobian_values(self, z: Float[ndarray, " size"]) -> Float[ndarray, " nonzeros"]:
        """Entries of the Jacobian in the order of `rows` and `columns`."""
        parts = []
        for kind in self._kinds:
            slopes = self.trajectory.sensitivity(z, self.instants, kind.order)[:, kind.joints]
            parts.append((slopes / kind.scale[:, None]).reshape(-1))
        return np.concatenate(parts) if parts else np.zeros(0)

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
        own = self.trajectory.variables.shape[1]
        whole = np.zeros((self.count, self.trajectory.size))
        entries = self.jacobian_values(z).reshape(-1, own)
        whole[np.arange(self.count)[:, None], self.columns.reshape(-1, own)] = entries
        below, above = self._bounded
        return np.concatenate([whole[below], -whole[above]])

    @cached_property
    def rows(self) -> ndarray:
        """Row of each structural nonzero of the Jacobian."""
        own = self.trajectory.variables.shape[1]
        return np.repeat(np.arange(self.count), own)

    @cached_property
    def columns(self) -> ndarray:
        """Column of each structural nonzero of the Jacobian."""
        variables = self.trajectory.variables
        parts = [
            np.tile(variables[kind.joints].reshape(-1), len(self.instants)) for kind in self._kinds
        ]
        return np.concatenate(parts) if parts else np.zeros(0, dtype=int)

    @cached_property
    def _bounded(self) -> tuple[ndarray, ndarray]:
        """Which rows have a lower bound, and which an upper one."""
        return np.isfinite(self.lower), np.isfinite(self.upper)

    def _stack(self, bounds: list[ndarray]) -> ndarray:
        tiled = [np.tile(bound, len(self.instants)) for bound in bounds]
        return np.concatenate(tiled) if tiled else np.zeros(0)

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
