"""Lambda and its gradient from the compiled regressor, joint by joint.

A row of joint j is zero in the columns of the links before it. Keeping each joint's own
columns alone halves the work, and its products are BLAS on contiguous rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.criteria import whitening
from oed.dynamics.compiled import CompiledRegressor
from oed.dynamics.motion import Motion


@dataclass(frozen=True)
class FastInformation:
    """Information of a motion under torque noise that is white in time.

    Attributes:
        regressor: The compiled base regressor.
        covariance: R_v at one instant, (n,) or (n, n); the identity if None.
    """

    regressor: CompiledRegressor
    covariance: Float[ndarray, "..."] | None = None

    def __post_init__(self) -> None:
        n = self.regressor.joints
        if self.covariance is not None and self.covariance.shape not in ((n,), (n, n)):
            raise ValueError(f"covariance {self.covariance.shape}: expected ({n},) or ({n}, {n})")

    def information(
        self, motion: Motion, sign_width: float = 0.0
    ) -> Float[ndarray, "columns columns"]:
        """H^T R_v^-1 H of a motion."""
        return self.information_and_entries(motion, sign_width)[0]

    def information_and_entries(
        self, motion: Motion, sign_width: float
    ) -> tuple[Float[ndarray, "columns columns"], Float[ndarray, "entries samples"]]:
        """H^T R_v^-1 H, and the regressor's entries that `adjoint` wants again."""
        entries = self.regressor.entries(motion, sign_width)
        total = np.zeros((self.regressor.columns, self.regressor.columns))
        for block, other, weight in self._pairs:
            rows, columns = entries[block.where], entries[other.where]
            part = weight * (rows @ columns.T)
            total[np.ix_(block.columns, other.columns)] += part
            if block is not other:
                total[np.ix_(other.columns, block.columns)] += part.T
        return total, entries

    def adjoint(
        self,
        entries: Float[ndarray, "entries samples"],
        slope: Float[ndarray, "columns columns"],
    ) -> Float[ndarray, "entries samples"]:
        """Gradient by the entries of a function whose gradient by Lambda is `slope`."""
        adjoint = np.zeros_like(entries)
        for block, other, weight in self._pairs:
            middle = 2 * weight * slope[np.ix_(block.columns, other.columns)]
            adjoint[block.where] += middle @ entries[other.where]
            if block is not other:
                adjoint[other.where] += middle.T @ entries[block.where]
        return adjoint

    @cached_property
    def _pairs(self) -> list[tuple[_Block, _Block, float]]:
        """Pairs of joints with correlated noise, and the entry of R_v^-1 that joins them."""
        n = self.regressor.joints
        where = [self.regressor.of_joint(j) for j in range(n)]
        blocks = [_Block(w, self.regressor.entry_column[w]) for w in where]
        if self.covariance is None:
            weights = np.eye(n)
        elif self.covariance.ndim == 1:
            weights = np.diag(1 / self.covariance)
        else:
            factor = whitening(self.covariance)
            weights = factor.T @ factor
        return [
            (blocks[i], blocks[j], float(weights[i, j]))
            for i in range(n)
            for j in range(i, n)
            if weights[i, j] != 0.0
        ]


@dataclass(frozen=True, eq=False)
class _Block:
    """One joint's entries: where they are and which columns they fill."""

    where: slice
    columns: ndarray
