"""The causal second-order filter that the paper runs at each sampling instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float
from numpy import ndarray
from scipy.optimize import root_scalar
from scipy.signal import lfilter


@dataclass(frozen=True)
class SecondOrderFilter:
    """y(k) = l1 u(k) + l2 y(k-1) + l3 y(k-2) (Calafiore 2001, section 3).

    Attributes:
        l1: Weight of the new sample.
        l2: Weight of the last output.
        l3: Weight of the output before.
        period: Sampling period [s].

    Raises:
        ValueError: If a pole lies on or outside the unit circle, or the period is not positive.
    """

    l1: float
    l2: float
    l3: float
    period: float

    def __post_init__(self) -> None:
        if self.period <= 0:
            raise ValueError(f"sampling period {self.period} s must be positive")
        largest = float(np.abs(self.poles).max())
        if largest >= 1:
            raise ValueError(f"unstable: the largest pole has magnitude {largest:.6g}")

    @property
    def poles(self) -> Complex[ndarray, "2"]:
        """Poles in the z plane."""
        return np.roots([1.0, -self.l2, -self.l3]).astype(complex)

    @property
    def dc_gain(self) -> float:
        """Gain for a constant."""
        return self.l1 / (1 - self.l2 - self.l3)

    def gain(self, frequency: float) -> complex:
        """Complex gain at a frequency [rad/s]."""
        back = np.exp(-1j * frequency * self.period)
        return complex(self.l1 / (1 - self.l2 * back - self.l3 * back**2))

    def half_power_frequency(self) -> float:
        """Lowest frequency [rad/s] at which the gain falls to 1/sqrt(2) of that at rest."""
        level = abs(self.dc_gain) / np.sqrt(2)
        nyquist = np.pi / self.period
        grid = np.geomspace(1e-6 * nyquist, nyquist, 2000)
        below = [abs(self.gain(w)) < level for w in grid]
        if not any(below):
            raise ValueError("the gain never falls to -3 dB below the Nyquist frequency")
        i = below.index(True)
        lower = float(grid[i - 1]) if i else 0.0
        found = root_scalar(
            lambda w: abs(self.gain(w)) - level, bracket=(lower, float(grid[i])), method="brentq"
        )
        return float(found.root)

    def apply(self, u: Float[ndarray, " samples *columns"]) -> Float[ndarray, " samples *columns"]:
        """Filter (N, ...) samples, as if the first had stood for ever."""
        start = np.asarray(u[:1]) * self.dc_gain
        denominator = [1.0, -self.l2, -self.l3]
        # States of the transposed direct form at rest under the first sample.
        state = np.concatenate([(self.l2 + self.l3) * start, self.l3 * start])
        filtered, _ = lfilter([self.l1], denominator, u, axis=0, zi=state)
        return filtered


# Calafiore 2001, section 3: velocity and torque at T = 1 ms, "cut-off about 14 rad/s". The poles
# are at 20 and 25 rad/s to five digits, so -3 dB lies at 14.27 rad/s.
PAPER_L2, PAPER_L3 = 1.95550858, -0.95599748
PAPER_FILTER = SecondOrderFilter(1 - PAPER_L2 - PAPER_L3, PAPER_L2, PAPER_L3, period=0.001)
