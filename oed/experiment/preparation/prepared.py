"""A recording as diagnosis sees it: motion on a fine grid, torque in the analysis band."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.experiment.preparation.band import Band
from oed.experiment.recording import Role


@dataclass(frozen=True, eq=False)
class Prepared:
    """One recording, ready to be compared with a model; equal to itself alone.

    Attributes:
        name: Of the recording.
        role: Of the recording.
        motion: N fine samples.
        fine_torque: (N, n) torque on the fine grid, unfiltered [N m].
        torque: (R, n) filtered rows [N m].
        t: (R,) time of the rows [s].
        band: Filter and decimation from fine samples to rows.
        repetition: (R,) repetition of each row, -1 where there is none.
        period: Of the motion, None without repetitions [s].
        position_noise: (n,) standard deviation of what encoders err in each sample of the log [rad].
        repeated_steps: (n,) of the encoders, as far as their rounding comes again in every
            repetition [rad].
        sign_noise: (n,) standard deviation of the velocity on the fine grid [rad/s].
        recorded: (N,) whether a fine sample lies between logged ones, not in a gap of the log.
        laid: Whether every recording started its clock anew, so that the times of `motion` lay
            them end to end in the order in which they are listed.
        laps: Of a mean repetition, its motion at the times of all that it is the mean of, one
            after another; None of others.
    """

    name: str
    role: Role
    motion: Motion
    fine_torque: Float[ndarray, "samples joints"]
    torque: Float[ndarray, "rows joints"]
    t: Float[ndarray, " rows"]
    band: Band
    repetition: Int[ndarray, " rows"]
    period: float | None
    position_noise: Float[ndarray, " joints"]
    repeated_steps: Float[ndarray, " joints"]
    sign_noise: Float[ndarray, " joints"]
    recorded: Bool[ndarray, " samples"]
    laid: bool = False
    laps: Motion | None = None

    @property
    def valid(self) -> Bool[ndarray, " rows"]:
        """Rows whose whole filter window was recorded."""
        missing = np.concatenate([[0], np.cumsum(~self.recorded)])
        window = len(self.band.taps)
        start = np.arange(self.rows) * self.band.factor
        return missing[start + window] == missing[start]

    @cached_property
    def place_in_period(self) -> Int[ndarray, " samples"]:
        """Index of each fine sample's phase; of the sample itself without repetitions."""
        if self.period is None:
            return np.arange(len(self.motion))
        return places_in_period(len(self.motion), self.period * self.band.rate)

    @property
    def rows(self) -> int:
        """Number of rows R."""
        return len(self.t)

    @property
    def samples(self) -> Int[ndarray, " rows"]:
        """Index of the fine sample in the middle of each row's filter window."""
        return self.band.reach + self.band.factor * np.arange(self.rows)

    @property
    def phase(self) -> Float[ndarray, " rows"]:
        """Time within the period, or the time itself without repetitions [s]."""
        return self.t if self.period is None else np.mod(self.t, self.period)


def places_in_period(samples: int, period: float) -> Int[ndarray, " samples"]:
    """Index within the period of each sample, the period in samples and no whole number of them."""
    return np.floor(np.mod(np.arange(samples) + 0.5, period)).astype(int)
