"""Torque of a nominal model at many instants, against its limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.base_parameters import BaseParameters
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
    """The torque as a sum over the regressor's entries.

    Attributes:
        regressor: The compiled base regressor.
        weights: (nnz,) base parameter of each entry.
        limits: (n, 2) torque limits [N m].
    """

    regressor: CompiledRegressor
    weights: Float[ndarray, " entries"]
    limits: Float[ndarray, "joints 2"]

    @classmethod
    def of(
        cls,
        regressor: CompiledRegressor,
        base: BaseParameters,
        nominal: Float[ndarray, " parameters"],
        limits: Float[ndarray, "joints 2"],
    ) -> NominalTorque:
        """From the parameters of the full model."""
        return cls(regressor, base.from_standard(nominal)[regressor.entry_column], limits)

    def torque(
        self, entries: Float[ndarray, "entries samples"]
    ) -> Float[ndarray, "joints samples"]:
        """Torque of every joint [N m]."""
        weighted = entries * self.weights[:, None]
        joints = range(self.regressor.joints)
        return np.stack([weighted[self.regressor.of_joint(j)].sum(axis=0) for j in joints])

    def excess(self, entries: Float[ndarray, "entries samples"]) -> float:
        """Worst share of `INSIDE` times a limit that is used, less 1; above 0 is too much."""
        return float(self._relative(self.torque(entries), INSIDE).max())

    def penalty(
        self, entries: Float[ndarray, "entries samples"]
    ) -> tuple[float, Float[ndarray, "entries samples"]]:
        """A smooth cost of excess torque [decades], and its gradient by the entries."""
        torque = self.torque(entries)
        beyond = np.maximum(self._relative(torque, PRICED), 0.0)
        bound = np.where(torque > 0, self.limits[:, 1:], self.limits[:, :1]) * PRICED
        by_torque = WEIGHT * 2 * beyond / bound / torque.shape[1]
        gradient = by_torque[self.regressor.entry_joint] * self.weights[:, None]
        return float(WEIGHT * (beyond**2).sum() / torque.shape[1]), gradient

    def _relative(self, torque: Float[ndarray, "joints samples"], share: float) -> ndarray:
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
