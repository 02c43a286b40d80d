"""A factor that rises from rest and returns to it, with its derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

# The polynomial of degree 7 from 0 to 1 whose first three derivatives vanish at both ends.
STEP = np.polynomial.Polynomial([0, 0, 0, 0, 35, -84, 70, -20])


@dataclass(frozen=True)
class Ramp:
    """w(t) with w = w' = w'' = w''' = 0 at 0 and at the horizon, and 1 in between.

    Attributes:
        horizon: [s]
        duration: Of the rise and of the fall [s]; at most half the horizon.
    """

    horizon: float
    duration: float

    def __post_init__(self) -> None:
        if not 0 < self.duration <= self.horizon / 2:
            raise ValueError(f"{self.duration=} is not within (0, {self.horizon / 2}]")

    def derivative(self, t: Float[ndarray, " samples"], order: int) -> Float[ndarray, " samples"]:
        """Time derivative of w [1/s^order]."""
        step = STEP.deriv(order) if order else STEP
        scale = self.duration**-order
        rise, fall = t / self.duration, (self.horizon - t) / self.duration
        flat = 1.0 if order == 0 else 0.0
        ends = np.where(rise < fall, step(rise), (-1.0) ** order * step(fall))
        return np.where(np.minimum(rise, fall) < 1.0, ends * scale, flat)

    def bound(self, order: int) -> float:
        """Upper bound on |derivative| for all t."""
        return self._bounds[order]

    @cached_property
    def _bounds(self) -> tuple[float, ...]:
        bounds = []
        for order in range(STEP.degree() + 1):
            step = STEP.deriv(order) if order else STEP
            turning = step.deriv().roots() if step.degree() > 0 else np.zeros(0)
            real = turning[np.abs(turning.imag) < 1e-9].real
            points = np.concatenate([[0.0, 1.0], real[(real > 0) & (real < 1)]])
            # A part in a million covers the rounding of the roots.
            bounds.append(float(np.abs(step(points)).max()) * self.duration**-order * (1 + 1e-6))
        return tuple(bounds)
