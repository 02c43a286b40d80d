"""A dense quasi-Newton matrix that stays positive definite (Powell 1978, damped BFGS)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy import ndarray

DAMPING = 0.2  # Powell's: least curvature kept, relative to the present matrix


class DampedBfgs:
    """Approximate Hessian of a Lagrangian, updated point by point.

    Attributes:
        matrix: (size, size) symmetric positive definite.
    """

    def __init__(self, size: int) -> None:
        """Start from the identity, rescaled at the first update."""
        self.matrix = np.eye(size)
        self._point: ndarray | None = None
        self._gradient = np.zeros(size)
        self._is_fresh = True

    def update(
        self,
        point: ndarray,
        gradient: ndarray,
        constraint_gradient: Callable[[ndarray], ndarray],
    ) -> None:
        """Learn from the step to a new point.

        Args:
            point: The new point.
            gradient: Of the objective there.
            constraint_gradient: Gradient at a point of the constraints weighted by the present
                multipliers, to be compared between the old point and the new.
        """
        if self._point is not None:
            step = point - self._point
            change = gradient - self._gradient
            change = change + constraint_gradient(point) - constraint_gradient(self._point)
            if step @ step > 1e-20:  # [squared half box widths] below it is rounding
                self._learn(step, change)
        self._point, self._gradient = point.copy(), gradient.copy()

    def _learn(self, step: ndarray, change: ndarray) -> None:
        curvature = step @ change
        if self._is_fresh and curvature > 0:
            self.matrix = self.matrix * (change @ change / curvature)
            self._is_fresh = False
        image = self.matrix @ step
        present = step @ image
        if curvature < DAMPING * present:
            theta = (1 - DAMPING) * present / (present - curvature)
            change = theta * change + (1 - theta) * image
            curvature = step @ change
        self.matrix = (
            self.matrix - np.outer(image, image) / present + np.outer(change, change) / curvature
        )
