"""The usual signal processing: zero-phase low-pass at 10 Hz, central differences, parallel decimation.

Gautier 1997, and Gautier, Janot and Vandanjon 2013, section IV; frequencies as they have them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import butter, decimate, filtfilt

from oed.dynamics.motion import Motion
from studies.estimators.arms import ContestArm

CUTOFF = 10.0  # [Hz]
ORDER = 4
LEFT = 0.8  # of the new rate that the decimation's filter leaves
HALF_WIDTH = 1.96  # standard deviations of a normal interval of 95 %
TRIMMED = 0.5  # [s] at each end, where filters have not settled


@dataclass(frozen=True)
class Equations:
    """W beta = y of one log, one band for both, rows of the joints weighted alike.

    Attributes:
        W: (rows, b) sample-major.
        y: (rows,) torque.
        joints: n.
    """

    W: Float[ndarray, "rows base"]
    y: Float[ndarray, " rows"]
    joints: int

    def weighted(self) -> Equations:
        """Each joint over its own residual's deviation."""
        return self.with_weights()[0]

    def with_weights(self) -> tuple[Equations, Float[ndarray, " rows"]]:
        """The same, and the weights."""
        rest = self.y - self.W @ np.linalg.lstsq(self.W, self.y, rcond=None)[0]
        deviation = np.sqrt(np.mean(rest.reshape(-1, self.joints) ** 2, axis=0))
        weight = np.tile(1 / deviation, len(self.y) // self.joints)
        return Equations(self.W * weight[:, None], self.y * weight, self.joints), weight


@dataclass(frozen=True)
class Recipe:
    """For logs of one rate.

    Attributes:
        rate: [Hz].
    """

    rate: float

    @property
    def factor(self) -> int:
        """Of the decimation."""
        return max(1, int(LEFT * self.rate / (2 * CUTOFF)))

    def motion(self, q: Float[ndarray, "rows joints"]) -> Motion:
        """Filtered, with central differences."""
        smooth = filtfilt(*butter(ORDER, CUTOFF, fs=self.rate), q, axis=0)  # pyright: ignore[reportCallIssue]  # SciPy has no types: by default these are b, a
        dq = np.gradient(smooth, 1 / self.rate, axis=0)
        ddq = np.gradient(dq, 1 / self.rate, axis=0)
        return Motion(np.arange(len(q)) / self.rate, smooth, dq, ddq)

    def thinned(self, series: Float[ndarray, "rows k"]) -> Float[ndarray, "fewer k"]:
        """Decimated; the ends are cut."""
        kept = decimate(series, self.factor, axis=0) if self.factor > 1 else series
        cut = int(np.ceil(TRIMMED * self.rate / self.factor))
        return kept[cut:-cut]

    def regressor(self, arm: ContestArm, motion: Motion) -> Float[ndarray, "rows base"]:
        """W of a motion at the logs' rate, in the decimation's band."""
        columns = arm.model.columns(motion)[:, :, arm.base.columns]
        samples, n, b = columns.shape
        return self.thinned(columns.reshape(samples, n * b)).reshape(-1, b)

    def equations(
        self, arm: ContestArm, q: Float[ndarray, "rows joints"], tau: Float[ndarray, "rows joints"]
    ) -> Equations:
        """Of one log."""
        W = self.regressor(arm, self.motion(q))
        return Equations(W, self.thinned(tau).reshape(-1), tau.shape[1])


@dataclass(frozen=True)
class Found:
    """An estimate.

    Attributes:
        parameters: (b,).
        interval: (b, 2) of 95 %; NaN where none is told.
    """

    parameters: Float[ndarray, " base"]
    interval: Float[ndarray, "base 2"]

    @classmethod
    def of_std(cls, parameters: Float[ndarray, " base"], std: Float[ndarray, " base"]) -> Found:
        """With normal intervals."""
        half = HALF_WIDTH * std
        return cls(parameters, np.stack([parameters - half, parameters + half], axis=1))

    @classmethod
    def bare(cls, parameters: Float[ndarray, " base"]) -> Found:
        """Without intervals."""
        return cls(parameters, np.full((len(parameters), 2), np.nan))
