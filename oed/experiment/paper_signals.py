"""From logged signals to regressor rows: the paper's way, and the ways that it missed.

Calafiore 2001, section 4: velocity and torque pass the same filter on line, acceleration is
the central difference of the filtered velocity. The authors "would have preferred" a
zero-phase filter; periodic motion has exact derivatives (Swevers et al. 1997).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.experiment.signals.differentiation import central_difference, spectral_derivative
from oed.experiment.signals.lowpass import lowpass
from oed.experiment.signals.online_filter import PAPER_FILTER
from oed.experiment.simulation import Log

# "online" is the paper to the letter: position is not filtered and so runs ahead of the rest.
# "aligned" delays it too.
Processing = Literal["online", "aligned", "zero_phase", "spectral"]
PROCESSINGS: tuple[Processing, ...] = ("online", "aligned", "zero_phase", "spectral")


@dataclass(frozen=True)
class SampledRuns:
    """R runs at S instants each.

    Attributes:
        motion: R S samples, run after run; `t` counts from the start of each run.
        tau: (R, S, n) processed torque [N m].
        raw: (R, S, n) torque as logged [N m].
    """

    motion: Motion
    tau: Float[ndarray, "runs samples joints"]
    raw: Float[ndarray, "runs samples joints"]

    @property
    def runs(self) -> int:
        """R."""
        return len(self.tau)

    def of(self, runs: slice) -> SampledRuns:
        """Some of the runs."""
        samples = self.tau.shape[1]
        rows = np.arange(self.runs * samples).reshape(self.runs, samples)[runs].ravel()
        return SampledRuns(self.motion[rows], self.tau[runs], self.raw[runs])


def sample_runs(
    log: Log, period: float, samples: int, processing: Processing, *, harmonics: int = 5
) -> SampledRuns:
    """Process the signals of all runs and keep S equally spaced instants of each.

    Lead-in and lead-out let the filters settle and are then dropped.

    Args:
        log: Raw signals.
        period: Sampling period [s].
        samples: S.
        processing: How.
        harmonics: Kept of the position, for "spectral" alone, where each run is one period.
    """
    q, dq, ddq, tau = _processed(log, period, processing, harmonics)
    kept = log.lead + np.round(np.arange(samples) * (log.samples / samples)).astype(int)

    def rows(x: Float[ndarray, "all joints runs"]) -> Float[ndarray, "rows joints"]:
        return np.ascontiguousarray(x[kept].transpose(2, 0, 1)).reshape(-1, x.shape[1])

    runs = log.t.shape[1]
    t = np.tile((kept - log.lead) * period, runs)
    shape = (runs, samples, log.command.shape[1])
    return SampledRuns(
        Motion(t, rows(q), rows(dq), rows(ddq)),
        rows(tau).reshape(shape),
        rows(log.command).reshape(shape),
    )


def _processed(
    log: Log, period: float, processing: Processing, harmonics: int
) -> tuple[ndarray, ndarray, ndarray, ndarray]:
    rate = 1 / period
    if processing in ("online", "aligned"):
        dq = PAPER_FILTER.apply(log.velocity)
        q = PAPER_FILTER.apply(log.measured) if processing == "aligned" else log.measured
        return q, dq, central_difference(dq, rate), PAPER_FILTER.apply(log.command)
    if processing == "zero_phase":
        cutoff = PAPER_FILTER.half_power_frequency() / (2 * np.pi)
        q, tau = (_zero_phase(x, rate, cutoff) for x in (log.measured, log.command))
        dq = central_difference(q, rate)
        return q, dq, central_difference(dq, rate), tau
    parts = [_spectral(log.measured, log, rate, harmonics, order) for order in range(3)]
    return parts[0], parts[1], parts[2], log.command


def _zero_phase(x: ndarray, rate: float, cutoff: float) -> ndarray:
    flat = lowpass(x.reshape(len(x), -1), rate, cutoff)
    return flat.reshape(x.shape)


def _spectral(x: ndarray, log: Log, rate: float, harmonics: int, order: int) -> ndarray:
    result = np.zeros_like(x)
    proper = slice(log.lead, log.lead + log.samples)
    result[proper] = spectral_derivative(x[proper], rate, harmonics=harmonics, order=order)
    return result
