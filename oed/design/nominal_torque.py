"""Torque of one model, or of several, at many instants, against its limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.compiled import CompiledRegressor

INSIDE = 0.98  # share of the limit that a design uses: room for what lies between instants
# Share from which torque has its price: what an optimum pays for goes beyond it by a percent or
# two. Above `INSIDE` all joints would shrink for that, by much where gravity takes most.
PRICED = 0.965
# Decades of cost per squared relative excess, averaged over instants. A design gains half a decade
# a percent of amplitude; where a tenth of the instants exceed, this holds them within a percent.
WEIGHT = 1e4
HALVINGS = 20  # to a millionth


@dataclass(frozen=True)
class NominalTorque:
    """The torque of each model as a sum over the regressor's entries.

    Attributes:
        regressor: The compiled regressor, with every model's columns.
        weights: (m, nnz) base parameter of each entry, one row a model.
        limits: (n, 2) torque limits [N m], which every model keeps.
    """

    regressor: CompiledRegressor
    weights: Float[ndarray, "models entries"]
    limits: Float[ndarray, "joints 2"]

    @classmethod
    def of(
        cls,
        regressor: CompiledRegressor,
        columns: Float[ndarray, "models columns"],
        limits: Float[ndarray, "joints 2"],
    ) -> NominalTorque:
        """From each model's factors of the regressor's columns."""
        return cls(regressor, columns[:, regressor.entry_column], limits)

    def torque(
        self, entries: Float[ndarray, "entries samples"]
    ) -> Float[ndarray, "models joints samples"]:
        """Torque of every model and joint [N m]."""
        places = [self.regressor.of_joint(j) for j in range(self.regressor.joints)]
        return np.stack([self.weights[:, own] @ entries[own] for own in places], axis=1)

    def share(self, entries: Float[ndarray, "entries samples"]) -> Float[ndarray, "models joints"]:
        """Largest share of its limit that each model needs at each joint."""
        return self._relative(self.torque(entries), 1.0).max(axis=2) + 1.0

    def excess(self, entries: Float[ndarray, "entries samples"]) -> float:
        """Worst share of `INSIDE` times a limit that is used, less 1; above 0 is too much."""
        return float(self._relative(self.torque(entries), INSIDE).max())

    def penalty(
        self, entries: Float[ndarray, "entries samples"]
    ) -> tuple[float, Float[ndarray, "entries samples"]]:
        """A smooth cost of excess torque [decades], and its gradient by the entries.

        At each instant that of the model that needs most of a joint's limit.
        """
        every = self.torque(entries)
        shares = self._relative(every, PRICED)
        worst = shares.argmax(axis=0)
        torque, share = (np.take_along_axis(x, worst[None], axis=0)[0] for x in (every, shares))
        beyond = np.maximum(share, 0.0)
        bound = np.where(torque > 0, self.limits[:, 1:], self.limits[:, :1]) * PRICED
        by_torque = WEIGHT * 2 * beyond / bound / torque.shape[1]
        joint = self.regressor.entry_joint
        weights = self.weights[worst[joint], np.arange(len(joint))[:, None]]
        return float(WEIGHT * (beyond**2).sum() / torque.shape[1]), by_torque[joint] * weights

    def _relative(self, torque: ndarray, share: float) -> ndarray:
        bound = np.where(torque > 0, self.limits[:, 1:], self.limits[:, :1])
        return torque / (share * bound) - 1.0


def largest_factor(excess: Callable[[float], float]) -> float:
    """The largest factor in [0, 1] at which `excess` is at most 0, by bisection.

    0 where even a motion at a standstill exceeds.
    """
    if excess(1.0) <= 0.0:
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) <= 0.0 else (low, middle)
    return low
