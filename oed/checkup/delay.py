"""By how much time the torque is logged before or after the motion that it belongs to.

The torque is moved against the motion, the model is fitted anew at every shift, and the likelihood says
which shift the log wants (maximum likelihood over a delay: Ljung 1999, System Identification, section
3.2; a cross-correlation of prediction and torque has the same peak, but a prediction fitted without a
shift has already given way to it).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.interpolate import CubicSpline

from oed.checkup.finding import EvidenceRow, Finding
from oed.checkup.repair import VERY_STRONG
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.triangular import factor_of
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.recording import HELD_OUT, Role
from oed.experiment.signals.moving_sum import moving_sum

LONGEST = 0.1  # [s] that buses, filters and time stamps of another clock are apart
STEPS = 20  # shifts tried on either side; a parabola through the best finds the time between them
RANK = 1e-8  # of the largest singular value, columns of one norm
LEAST_GAIN = 0.05  # of the rms residual: below it the shift is no trouble whatever its evidence
REWEIGHTINGS = 3  # of the joints, at no shift
ROUNDING = 1e-10  # of a joint's mean squared torque


@dataclass(frozen=True)
class Delay:
    """What the log says of a shift.

    Attributes:
        seconds: By which the torque comes after the motion; negative if before.
        evidence: 2 log of the likelihood ratio of that shift to none.
        before: (n,) rms residual without a shift [N m or N].
        after: (n,) with the best shift [N m or N].
        is_inside: Whether the best lies within the shifts that were tried.
    """

    seconds: float
    evidence: float
    before: Float[ndarray, " joints"]
    after: Float[ndarray, " joints"]
    is_inside: bool

    @property
    def gain(self) -> float:
        """Share of the rms residual that the shift removes, geometric mean over joints."""
        return float(1 - np.exp(np.mean(np.log(self.after / self.before))))


def find_delay(model: TorqueModel, recordings: Sequence[ProcessedRecording]) -> Delay:
    """The shift of the torque that makes the log likeliest, fitted anew at each.

    Args:
        model: Of the torque.
        recordings: For estimation, processed.

    Raises:
        ValueError: If every recording is too short to be shifted.
    """
    shifts = np.linspace(-LONGEST, LONGEST, 2 * STEPS + 1)
    factors, samples = _factors(model, recordings, shifts)
    if not samples:
        raise ValueError(f"no recording is longer than {2 * LONGEST:g} s")
    variances = _variances(factors, samples, len(shifts))
    rate, band = recordings[0].rate, recordings[0].bandwidth
    independent = 2 * band * samples / rate
    deviance = independent * np.log(variances).sum(axis=1)
    best = int(deviance.argmin())
    is_inside = 0 < best < len(shifts) - 1
    seconds = float(shifts[best])
    if is_inside:
        low, middle, high = deviance[best - 1 : best + 2]
        curvature = low - 2 * middle + high
        if curvature > 0:
            seconds += float(0.5 * (low - high) / curvature * (shifts[1] - shifts[0]))
    return Delay(
        seconds=seconds,
        evidence=float(deviance[STEPS] - deviance[best]),
        before=np.sqrt(variances[STEPS]),
        after=np.sqrt(variances[best]),
        is_inside=is_inside,
    )


def delay_finding(
    dataset: DataSet,
    model: TorqueModel,
    recordings: Mapping[Role, Sequence[ProcessedRecording]],
) -> Finding:
    """Whether torque and motion are of the same time.

    A short recording is explained a little better by almost any change. Where recordings are held
    out they are asked by themselves, and must say the same.

    Args:
        dataset: As read.
        model: Of its robot.
        recordings: By role, processed.
    """
    topic = "time of the torque"
    step = min(float(np.median(np.diff(r.t))) for r in dataset.estimation)
    held = [r for role in HELD_OUT for r in recordings.get(role, ())]
    try:
        delay = find_delay(model, recordings["estimation"])
        told = _is_told(delay, step)
        if told and held:
            again = find_delay(model, held)
            told = _is_told(again, step) and _agree(delay, again)
    except ValueError as error:
        return Finding(topic, "green", f"not looked at: {error}")
    rows: tuple[EvidenceRow, ...] = tuple(
        {
            "joint": name,
            f"residual as logged [{dataset.torque_unit}]": float(delay.before[j]),
            f"residual shifted [{dataset.torque_unit}]": float(delay.after[j]),
        }
        for j, name in enumerate(dataset.robot.joint_names)
    )
    if not told:
        text = f"no shift of up to {1e3 * LONGEST:g} ms between torque and motion explains the log better"
        return Finding(topic, "green", text, "", rows)
    way, mend = ("after", "earlier") if delay.seconds > 0 else ("before", "later")
    size = 1e3 * abs(delay.seconds)
    return Finding(
        topic,
        "amber",
        f"torque is logged {size:.3g} ms {way} the motion that it belongs to: moved by as much, the "
        f"residual falls by {100 * delay.gain:.2g} % (2 log likelihood ratio {delay.evidence:.3g}"
        + ("; the held-out recordings by themselves say the same)" if held else ")"),
        f"move the tau columns by {size:.3g} ms {mend}, or log both with one clock and one filter",
        rows,
    )


def _is_told(delay: Delay, step: float) -> bool:
    return bool(
        delay.evidence > VERY_STRONG
        and delay.gain > LEAST_GAIN
        and abs(delay.seconds) > step / 2
        and delay.is_inside
    )


def _agree(one: Delay, other: Delay) -> bool:
    """Whether two shifts are to the same side, and differ by less than half of the larger."""
    larger = max(abs(one.seconds), abs(other.seconds))
    return abs(one.seconds - other.seconds) < 0.5 * larger


def _factors(
    model: TorqueModel, recordings: Sequence[ProcessedRecording], shifts: Float[ndarray, " shifts"]
) -> tuple[list[Float[ndarray, "width width"]], int]:
    """Triangular factor of each joint's rows [columns | torques at all shifts], and their samples.

    A piece of a recording at a time: the rows of all are never held together.
    """
    width = len(model.parameters) + len(shifts)
    factors, samples = [np.zeros((0, width))] * model.robot.n, 0
    for recording in recordings:
        for columns, torque in _shifted(model, recording, shifts):
            samples += len(columns)
            factors = [
                factor_of([factor, np.column_stack([columns[:, j], torque[:, :, j]])])
                for j, factor in enumerate(factors)
            ]
    return factors, samples


def _shifted(
    model: TorqueModel, recording: ProcessedRecording, shifts: Float[ndarray, " shifts"]
) -> Iterator[tuple[ndarray, ndarray]]:
    """Columns (N, n, p), and torques (N, shifts, n) taken from later or earlier by each shift."""
    t = recording.motion.t
    inside = np.flatnonzero((t >= t[0] + LONGEST) & (t <= t[-1] - LONGEST))
    if len(inside) < 2:
        return
    band = recording.band
    # On the fine grid, where a cubic spline is the signal.
    dense = moving_sum(recording.fine_tau, band.taps)
    spline = CubicSpline(recording.fine.t[band.reach : len(recording.fine) - band.reach], dense)
    rows = slice(int(inside[0]), int(inside[-1]) + 1)
    for place, columns in recording.pieces(model.columns, remembers=model.remembers, rows=rows):
        yield columns, np.stack([spline(t[place] + shift) for shift in shifts], axis=1)


def _variances(
    factors: Sequence[Float[ndarray, "width width"]], samples: int, shifts: int
) -> Float[ndarray, "shifts joints"]:
    """Mean squared residual of each joint at each shift, joints weighted by theirs at none."""
    norms = np.linalg.norm(np.concatenate(factors)[:, :-shifts], axis=0)
    used = norms > 0
    p = int(used.sum())
    power = np.array([np.sum(f[:, -shifts:] ** 2) for f in factors]) / (samples * shifts)
    factors = [
        np.column_stack([f[:, :-shifts][:, used] / norms[used], f[:, -shifts:]]) for f in factors
    ]
    floor = ROUNDING * np.where(power > 0, power, 1.0)
    weights = np.where(power > 0, power, 1.0)
    found = np.empty((shifts, len(factors)))
    for _ in range(REWEIGHTINGS):
        stacked = np.vstack([f / np.sqrt(w) for f, w in zip(factors, weights, strict=True)])
        solved = np.linalg.lstsq(stacked[:, :p], stacked[:, p:], rcond=RANK)[0]
        for j, factor in enumerate(factors):
            residual = factor[:, p:] - factor[:, :p] @ solved
            found[:, j] = np.sum(residual**2, axis=0) / samples
        weights = np.maximum(found[shifts // 2], floor)
    return np.maximum(found, floor)
