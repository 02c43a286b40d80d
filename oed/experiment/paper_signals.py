"""From logged signals to regressor rows: the paper's way, and the ways that it missed.

Calafiore 2001, section 4: velocity and torque pass the same filter on line, acceleration is
the central difference of the filtered velocity. The authors "would have preferred" a
zero-phase filter; periodic motion has exact derivatives (Swevers et al. 1997).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.dynamics.planar import planar_regressor
from oed.experiment.signals.differentiation import central_difference, spectral_derivative
from oed.experiment.signals.lowpass import half_power_frequency, lowpass
from oed.experiment.signals.online_filter import PAPER_FILTER
from oed.experiment.simulation import Log
from oed.robot.builtin import IMI_LINK_LENGTHS

# "online" is the paper to the letter: position is not filtered and so runs ahead of the rest.
# "aligned" delays it too. "zero_phase" is what the authors wanted, at the same half power.
# "spectral" takes exact derivatives of the mean harmonics of a periodic motion. "parallel"
# forms the regressor from wide-band signals and filters its columns as it filters the torque
# (Gautier 1997, "Dynamic identification of robots with power model"): no filter can then
# come between the two sides of the equation.
Processing = Literal["online", "aligned", "zero_phase", "parallel", "spectral"]
Regressor = Callable[[Motion], Float[ndarray, "samples joints columns"]]
WIDE_BAND = 10.0  # cut-off of the regressor's signals before "parallel" filtering, of the filter's


@dataclass(frozen=True)
class SampledRuns:
    """R runs at S instants each.

    Attributes:
        columns: (R, S, n, c) regressor (16), or the one asked for.
        tau: (R, S, n) processed torque [N m].
        raw: (R, S, n) torque as logged [N m].
    """

    columns: Float[ndarray, "runs samples joints columns"]
    tau: Float[ndarray, "runs samples joints"]
    raw: Float[ndarray, "runs samples joints"]

    @property
    def runs(self) -> int:
        """R."""
        return len(self.tau)

    @property
    def regressor(self) -> Float[ndarray, "rows columns"]:
        """H of (6a), run after run."""
        return self.columns.reshape(-1, self.columns.shape[3])

    def of(self, runs: slice) -> SampledRuns:
        """Some of the runs."""
        return SampledRuns(self.columns[runs], self.tau[runs], self.raw[runs])


def paper_regressor(motion: Motion) -> Float[ndarray, "samples 2 8"]:
    """Regressor (16) of the paper's arm."""
    return planar_regressor(motion, IMI_LINK_LENGTHS[0])


def sample_runs(
    log: Log,
    period: float,
    samples: int,
    processing: Processing,
    *,
    harmonics: int = 5,
    regressor: Regressor = paper_regressor,
) -> SampledRuns:
    """Process the signals of all runs and keep S equally spaced instants of each.

    Lead-in and lead-out let the filters settle and are then dropped.

    Args:
        log: Raw signals.
        period: Sampling period [s].
        samples: S.
        processing: How.
        harmonics: Kept of the position, for "spectral" alone, where each run is one period.
        regressor: Of the motion's instants.
    """
    kept = log.lead + np.round(np.arange(samples) * (log.samples / samples)).astype(int)
    if processing == "parallel":
        columns, tau = _parallel(log, period, regressor)
        columns = columns[:, kept]
    else:
        q, dq, ddq, tau = processed_signals(log, period, processing, harmonics=harmonics)
        columns = _columns(regressor, *(x[kept] for x in (q, dq, ddq)))
    return SampledRuns(columns, _by_run(tau[kept]), _by_run(log.command[kept]))


def zero_phase_cutoff() -> float:
    """Cut-off of the forward-backward filter whose half power is the paper's [Hz]."""
    wanted = PAPER_FILTER.half_power_frequency() / (2 * np.pi)
    return wanted / (half_power_frequency(1.0))


def processed_signals(
    log: Log, period: float, processing: Processing, *, harmonics: int = 5
) -> tuple[ndarray, ndarray, ndarray, ndarray]:
    """Position, velocity, acceleration and torque at every sample, (N, n, R) each."""
    rate = 1 / period
    if processing in ("online", "aligned"):
        dq = PAPER_FILTER.apply(log.velocity)
        q = PAPER_FILTER.apply(log.measured) if processing == "aligned" else log.measured
        return q, dq, central_difference(dq, rate), PAPER_FILTER.apply(log.command)
    if processing == "zero_phase":
        cutoff = zero_phase_cutoff()
        q, tau = (_zero_phase(x, rate, cutoff) for x in (log.measured, log.command))
        dq = central_difference(q, rate)
        return q, dq, central_difference(dq, rate), tau
    if processing != "spectral":
        raise ValueError(f"processing {processing!r} gives no signals, only a regressor")
    parts = [_spectral(log.measured, log, rate, harmonics, order) for order in range(3)]
    return parts[0], parts[1], parts[2], log.command


def _parallel(log: Log, period: float, regressor: Regressor) -> tuple[ndarray, ndarray]:
    """(R, N, n, c) filtered regressor columns and (N, n, R) filtered torque."""
    rate = 1 / period
    cutoff = WIDE_BAND * PAPER_FILTER.half_power_frequency() / (2 * np.pi)
    q = _zero_phase(log.measured, rate, cutoff)
    dq = central_difference(q, rate)
    columns = _columns(regressor, q, dq, central_difference(dq, rate))
    # Run by run, so that one run's filter does not see the next.
    filtered = np.stack([PAPER_FILTER.apply(run) for run in columns])
    return filtered, PAPER_FILTER.apply(log.command)


def _columns(
    regressor: Regressor,
    q: Float[ndarray, "kept joints runs"],
    dq: Float[ndarray, "kept joints runs"],
    ddq: Float[ndarray, "kept joints runs"],
) -> Float[ndarray, "runs kept joints columns"]:
    kept, joints, runs = q.shape
    flat = [_by_run(x).reshape(-1, joints) for x in (q, dq, ddq)]
    motion = Motion(np.zeros(kept * runs), *flat)
    return regressor(motion).reshape(runs, kept, joints, -1)


def _by_run(x: Float[ndarray, "kept joints runs"]) -> Float[ndarray, "runs kept joints"]:
    return np.ascontiguousarray(x.transpose(2, 0, 1))


def _zero_phase(x: ndarray, rate: float, cutoff: float) -> ndarray:
    flat = lowpass(x.reshape(len(x), -1), rate, cutoff)
    return flat.reshape(x.shape)


def _spectral(x: ndarray, log: Log, rate: float, harmonics: int, order: int) -> ndarray:
    result = np.zeros_like(x)
    proper = slice(log.lead, log.lead + log.samples)
    result[proper] = spectral_derivative(x[proper], rate, harmonics=harmonics, order=order)
    return result
