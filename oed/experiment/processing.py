"""From a recording to the motion and torque that an estimate is made of.

Torque and model pass the same filter: the model is evaluated on a finely sampled, lightly
smoothed motion, and its columns are then low-passed and decimated like the torque (parallel
filtering, Gautier 1997, "Dynamic identification of robots with power model"). Filtering the
motion alone would leave steps in the model's friction that the torque has lost, and bias it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.experiment.recording import Recording, Role
from oed.experiment.signals.differentiation import spline_derivative
from oed.experiment.signals.lowpass import lowpass
from oed.experiment.signals.resampling import (
    Interpolation,
    fresh_rows,
    resample,
    uniform_grid,
)
from oed.experiment.temperature import joint_temperature

VelocitySource = Literal["differentiated", "logged"]


# Position may reach this many times beyond the cut-off: its filter leaves the band alone, and what
# noise it lets through the model's own filter takes away.
MOTION_BAND = 2.0
HIGHEST_SHARE = 0.4  # of the rate, for any cut-off
# A change of sign between two fine samples is misplaced by half of one: at 40 a period of the
# cut-off that is lost in the filter.
FINE_SAMPLES_PER_CUTOFF = 40.0


@dataclass(frozen=True)
class ProcessingSettings:
    """How recordings become motion and torque; `choose_settings` proposes one.

    Attributes:
        rate: Of the uniform grid that everything is brought to [Hz].
        cutoff: Of the zero-phase low-pass of torque and model alike [Hz].
        order: Of the one-way Butterworth filter.
        decimation: Every how many-th sample of the grid is kept.
        trim: Cut at each end, where the filter has not settled [s].
        velocity: "differentiated" from the filtered position, or the "logged" dq.
        interpolation: Between the logged instants.
        drop_repeats: Whether rows that repeat their predecessor exactly are left out.
        reasons: One line a setting, why it was chosen.

    Raises:
        ValueError: If a setting is out of its range.
    """

    rate: float
    cutoff: float
    order: int = 4
    decimation: int = 1
    trim: float = 0.0
    velocity: VelocitySource = "differentiated"
    interpolation: Interpolation = "cubic"
    drop_repeats: bool = True
    reasons: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        if not 0 < self.cutoff < self.rate / 2:
            raise ValueError(
                f"cut-off {self.cutoff:g} Hz must lie between 0 and half the rate {self.rate:g} Hz"
            )
        if self.decimation < 1 or self.order < 1:
            raise ValueError(f"decimation {self.decimation}, order {self.order}: both at least 1")
        if self.cutoff > self.output_rate / 2:
            raise ValueError(
                f"{self.output_rate:g} Hz after decimation by {self.decimation} cannot carry "
                f"signals up to {self.cutoff:g} Hz"
            )
        if self.trim < 0:
            raise ValueError(f"trim {self.trim:g} s must not be negative")
        if self.velocity not in ("differentiated", "logged"):
            raise ValueError(f"velocity {self.velocity!r} is neither differentiated nor logged")

    @property
    def output_rate(self) -> float:
        """Sampling rate of the result [Hz]."""
        return self.rate / self.decimation

    @property
    def motion_cutoff(self) -> float:
        """Cut-off of the smoothing of position and velocity [Hz]."""
        return min(MOTION_BAND * self.cutoff, HIGHEST_SHARE * self.rate)

    @property
    def fine_step(self) -> int:
        """Samples of the grid to one at which the model is evaluated; divides the decimation."""
        wanted = max(1, int(self.rate / (FINE_SAMPLES_PER_CUTOFF * self.cutoff)))
        return max(step for step in range(1, wanted + 1) if self.decimation % step == 0)

    @property
    def fine_rate(self) -> float:
        """Rate at which the model is evaluated and filtered [Hz]."""
        return self.rate / self.fine_step

    def kept(self, fine: int) -> slice:
        """Which of `fine` samples at the fine rate remain after trimming and decimation."""
        cut = int(np.ceil(self.trim * self.fine_rate))
        return slice(cut, fine - cut, self.decimation // self.fine_step)

    def with_cutoff(self, cutoff: float) -> ProcessingSettings:
        """These settings with another cut-off [Hz], and the decimation and trim that suit it.

        Raises:
            ValueError: If the cut-off is not between 0 and half the rate.
        """
        if not 0 < cutoff < self.rate / 2:
            raise ValueError(
                f"cut-off {cutoff:g} Hz must lie between 0 and {self.rate / 2:g} Hz, half the "
                f"rate of {self.rate:g} Hz"
            )
        return dataclasses.replace(
            self,
            cutoff=cutoff,
            decimation=suitable_decimation(self.rate, cutoff),
            trim=suitable_trim(cutoff),
            reasons=(f"cut-off {cutoff:g} Hz: given",),
        )

    def thinned(self) -> ProcessingSettings:
        """These settings with as few samples as still carry the band: for a quick look."""
        fewest = max(self.decimation, int(self.rate / (LEAST_SAMPLES_PER_CUTOFF * self.cutoff)))
        return dataclasses.replace(self, decimation=fewest)

    def __str__(self) -> str:
        return "\n".join(self.reasons)


@dataclass(frozen=True)
class ProcessedRecording:
    """Motion and torque of one recording, in one frequency band.

    Attributes:
        name: Of the recording.
        role: Of the recording.
        motion: N samples on a uniform grid.
        tau: (N, n) torque, low-passed [N m or N].
        fine: The motion that the model is evaluated on, at the rate of the filter.
        settings: Of the processing.
        rate: Sampling rate [Hz].
        bandwidth: Cut-off of the low-pass [Hz]: successive residuals are correlated over
            about 1 / (2 bandwidth).
        repetition: (N,) repetition that each sample belongs to, where the recording says.
    """

    name: str
    role: Role
    motion: Motion
    tau: Float[ndarray, "samples joints"]
    fine: Motion
    settings: ProcessingSettings
    rate: float
    bandwidth: float
    repetition: Int[ndarray, " samples"] | None = None

    def __post_init__(self) -> None:
        if self.tau.shape != self.motion.q.shape:
            raise ValueError(f"tau is {self.tau.shape}, q is {self.motion.q.shape}")

    def __len__(self) -> int:
        return len(self.tau)

    def columns(
        self, evaluate: Callable[[Motion], Float[ndarray, "fine joints columns"]]
    ) -> Float[ndarray, "samples joints columns"]:
        """A model's columns in the band of `tau`, at its samples.

        Args:
            evaluate: The columns at every instant of a motion.
        """
        columns = evaluate(self.fine)
        settings = self.settings
        kept = settings.kept(len(columns))
        found = np.empty((len(self), *columns.shape[1:]))
        # Joint by joint: the filter works on several copies of what it is given.
        for j in range(columns.shape[1]):
            found[:, j] = lowpass(
                columns[:, j], settings.fine_rate, settings.cutoff, settings.order
            )[kept]
        return found


# Ten samples a cut-off period keep the band with a wide margin for the filter's slope.
SAMPLES_PER_CUTOFF = 10.0
LEAST_SAMPLES_PER_CUTOFF = 2.5
# The filter's response to a wrong guess beyond an end decays within this many periods of the
# cut-off; a tenth of a second is cut in any case, where loggers and drives settle.
TRIM_PERIODS = 1.5
LEAST_TRIM = 0.1  # [s]


def suitable_decimation(rate: float, cutoff: float) -> int:
    """Largest decimation that leaves ten samples a period of the cut-off."""
    return max(1, int(rate / (SAMPLES_PER_CUTOFF * cutoff) + 1e-9))


def suitable_trim(cutoff: float) -> float:
    """Time to cut at each end [s]."""
    return max(LEAST_TRIM, TRIM_PERIODS / cutoff)


def process(recording: Recording, settings: ProcessingSettings) -> ProcessedRecording:
    """Resample, low-pass, differentiate, trim and decimate one recording.

    The torque is low-passed at the cut-off. Position is smoothed at twice that, where it does
    not touch the band, and differentiated; `ProcessedRecording.columns` filters the model.

    Raises:
        ValueError: If the recording is too short for the settings, or has no logged
            velocity where they ask for it.
    """
    logged = recording.dq if settings.velocity == "logged" else None
    if settings.velocity == "logged" and logged is None:
        raise ValueError(f"{recording.name}: no dq was logged; choose velocity='differentiated'")
    fresh = (
        fresh_samples(recording) if settings.drop_repeats else np.ones(len(recording), dtype=bool)
    )
    grid = uniform_grid(recording.t, settings.rate)
    cut = int(np.ceil(settings.trim * settings.rate))
    if len(grid) - 2 * cut < 3 or fresh.sum() < 4:
        raise ValueError(
            f"{recording.name}: {recording.duration:g} s are too short to trim "
            f"{settings.trim:g} s at each end at {settings.rate:g} Hz"
        )

    def smooth(x: Float[ndarray, "samples joints"]) -> Float[ndarray, "grid joints"]:
        uniform = resample(recording.t[fresh], x[fresh], grid, settings.interpolation)
        return lowpass(uniform, settings.rate, settings.motion_cutoff, settings.order)

    q = smooth(recording.q)
    if logged is None:
        dq, ddq = (spline_derivative(q, settings.rate, order) for order in (1, 2))
    else:
        dq = smooth(logged)
        ddq = spline_derivative(dq, settings.rate)
    whole = Motion(grid, q, dq, ddq, temperature=joint_temperature(recording, grid))
    # The torque is smoothed too: what is linear in the motion then sees one and the same filter.
    tau = lowpass(smooth(recording.tau), settings.rate, settings.cutoff, settings.order)
    fine = whole[:: settings.fine_step]
    kept = settings.kept(len(fine))
    return ProcessedRecording(
        name=recording.name,
        role=recording.role,
        motion=fine[kept],
        tau=tau[:: settings.fine_step][kept],
        fine=fine,
        settings=settings,
        rate=settings.output_rate,
        bandwidth=settings.cutoff,
        repetition=_repetition_at(recording, fine.t[kept]),
    )


def fresh_samples(recording: Recording) -> Bool[ndarray, " samples"]:
    """Rows of a recording that are not stale copies of the row before."""
    fresh = fresh_rows(*(x for x in (recording.q, recording.dq, recording.tau) if x is not None))
    # The last instant anchors the grid's end even where it is stale.
    fresh[-1] = True
    return fresh


def _repetition_at(
    recording: Recording, instants: Float[ndarray, " samples"]
) -> Int[ndarray, " samples"] | None:
    if recording.repetition is None:
        return None
    before = np.searchsorted(recording.t, instants + 1e-9, side="right") - 1
    return recording.repetition[before]
