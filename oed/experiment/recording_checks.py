"""What must hold of a recording's numbers before they are believed."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.counted import counted
from oed.errors import DataSetError
from oed.experiment.manifest import RecordingEntry
from oed.experiment.recording import LEAST_TRAVEL
from oed.experiment.signals.gaps import find_gaps
from oed.robot import Robot

PARAMETERS_PER_JOINT = 12  # ten inertial parameters, Coulomb and viscous friction
# A joint cannot be this far beyond its limits; degrees taken for radians are 57 times too large,
# and even a motion over a tenth of the range shows.
BEYOND_LIMITS = 5.0
LEAST_TORQUE = 1e-9  # [N m, N or A] that no sensor of a drive resolves
# [s] Between rows: at 5 Hz no motion of an arm can be followed, and a log of 5 kHz whose time is in
# milliseconds has this step.
LARGEST_STEP = 0.2
TIME_UNITS = ((1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds"))
TURN_TOLERANCE = 0.5  # [rad] that an arm may move between two rows beside the turn
# A leap is at least this share of a joint's travel, and so many times what nearly all rows differ
# by, and those just before and after it: one row or two, as no arm moves.
LEAP_SHARE = 0.1
LEAP_RATIO = 20.0
USUAL = 0.99  # of the rows
PERIOD_TOLERANCE = 0.002  # of the span: clocks of motion and logger differ by far less


def check_rows(t: Float[ndarray, " samples"], joints: int, file: str) -> None:
    """Refuse fewer rows than the torque model of `joints` joints has parameters."""
    needed = PARAMETERS_PER_JOINT * joints
    if len(t) < needed:
        message = (
            f"{len(t)} rows are fewer than the {needed} parameters of {joints} joints "
            f"({PARAMETERS_PER_JOINT} each: inertia, Coulomb and viscous friction); record longer"
        )
        raise DataSetError(message, file=file)


def check_time(t: Float[ndarray, " samples"], file: str, lines: Int[ndarray, " samples"]) -> None:
    """Refuse time that repeats or runs back, and steps that cannot be seconds."""
    stuck = np.flatnonzero(np.diff(t) <= 0)
    if stuck.size:
        i = int(stuck[0])
        # Digits enough to tell rows apart in seconds since 1970.
        what, advice = "repeats", "drop the repeated rows, or log time with more digits"
        if t[i + 1] < t[i]:
            what, advice = (
                "runs back",
                "sort the rows, or list each run as a recording, by its rows",
            )
        message = f"time {what}: {t[i]:.16g} s is followed by {t[i + 1]:.16g} s; {advice}"
        raise DataSetError(message, file=file, row=int(lines[i + 1]), column="t")
    step = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    if step >= LARGEST_STEP * (1 - 1e-6):
        unit = next((name for factor, name in TIME_UNITS if step < LARGEST_STEP * factor), "")
        message = (
            f"rows are {step:.4g} s apart, too far to follow an arm: this looks like "
            f"{unit or 'another unit'} or a count of samples; convert it to seconds"
        )
        raise DataSetError(message, file=file, column="t")


def check_positions(
    q: Float[ndarray, "samples joints"], robot: Robot, file: str, lines: Int[ndarray, " samples"]
) -> None:
    """Refuse positions so far beyond the limits that they must be degrees."""
    bound = np.abs(robot.limits.position).max(axis=1)
    for j, joint in enumerate(robot.joints):
        row = int(np.abs(q[:, j]).argmax())
        largest = float(abs(q[row, j]))
        if largest <= BEYOND_LIMITS * bound[j]:
            continue
        unit = "rad" if joint.kind == "revolute" else "m"
        advice = (
            "this looks like degrees; convert positions and velocities to radians"
            if joint.kind == "revolute"
            else "this looks like millimetres; convert to metres"
        )
        message = (
            f"|q| = {largest:.5g} is {largest / bound[j]:.3g} times the limit of joint "
            f"{joint.name!r}, {bound[j]:.4g} {unit}: {advice}"
        )
        raise DataSetError(message, file=file, row=int(lines[row]), column=f"q_{j + 1}")


def check_turns(
    t: Float[ndarray, " samples"],
    q: Float[ndarray, "samples joints"],
    robot: Robot,
    file: str,
    lines: Int[ndarray, " samples"],
) -> None:
    """Refuse positions that leap: angles folded into one turn, and encoders that lose count."""
    is_gap = np.zeros(len(t) - 1, dtype=bool)
    is_gap[find_gaps(t, np.inf)] = True
    for j, joint in enumerate(robot.joints):
        leap = np.diff(q[:, j])
        turns = (np.abs(np.abs(leap) - 2 * np.pi) < TURN_TOLERANCE) & ~is_gap
        if joint.kind == "revolute" and turns.any():
            row = int(np.flatnonzero(turns)[0]) + 1
            message = (
                f"joint {joint.name!r} leaps by {leap[row - 1]:.4g} rad from the row before, a "
                "whole turn: the angle is folded; unfold it (NumPy: unwrap)"
            )
            raise DataSetError(message, file=file, row=int(lines[row]), column=f"q_{j + 1}")
        leaps = np.flatnonzero(_is_leap(np.abs(leap), float(np.ptp(q[:, j]))) & ~is_gap)
        if len(leaps):
            row = int(leaps[0]) + 1
            message = (
                f"joint {joint.name!r} leaps by {leap[row - 1]:.4g} {joint.unit('rad')} from the row "
                f"before, as no arm moves, and {len(leaps)} times in all: an encoder that wraps or "
                "loses count, or a faulty row; unfold or remove it"
            )
            raise DataSetError(message, file=file, row=int(lines[row]), column=f"q_{j + 1}")


def _is_leap(change: Float[ndarray, " changes"], travel: float) -> Bool[ndarray, " changes"]:
    """Which changes from row to row stand alone in a joint's travel; a faulty row makes two."""
    beside = np.pad(change, 2, mode="edge")
    around = np.maximum(beside[:-4], beside[4:])
    usual = np.quantile(change, USUAL)
    return (change > LEAP_SHARE * travel) & (change > LEAP_RATIO * np.maximum(around, usual))


def check_signals(
    q: Float[ndarray, "samples joints"],
    tau: Float[ndarray, "samples joints"],
    file: str,
    robot: Robot,
) -> None:
    """Refuse torque that was not logged, and an arm that stands still.

    Args:
        q: Positions of the robot's joints.
        tau: Their torques.
        file: For the message.
        robot: With the joints that are kept.
    """
    for joint, torque in zip(robot.joints, tau.T, strict=True):
        spread = float(np.ptp(torque))
        if spread < LEAST_TORQUE:
            value = f"is {abs(torque[0]):g} in" if spread == 0 else f"varies by {spread:.2g} over"
            message = (
                f"the torque of joint {joint.name!r} {value} every row: it was not logged; log it, "
                "or name the others, with --columns q=NAME,NAME where a log is imported, with --joints where a "
                "data set is read"
            )
            raise DataSetError(message, file=file)
    travel = float(np.ptp(q, axis=0).max())
    if travel < LEAST_TRAVEL:
        message = (
            f"no joint moves by more than {travel:.2g} rad or m: an arm at rest shows no dynamics; "
            "record a motion, or leave this recording out"
        )
        raise DataSetError(message, file=file)


def repetition_index(
    values: Float[ndarray, " samples"], file: str, lines: Int[ndarray, " samples"]
) -> Int[ndarray, " samples"]:
    """The `repetition` column as whole numbers that never fall."""
    wrong = np.flatnonzero((values < 0) | (values != np.round(values)))
    if wrong.size:
        row = int(wrong[0])
        message = f"{values[row]:g} is not a repetition; count them 0, 1, 2, …"
        raise DataSetError(message, file=file, row=int(lines[row]), column="repetition")
    falls = np.flatnonzero(np.diff(values) < 0)
    if falls.size:
        row = int(falls[0]) + 1
        message = f"repetition {values[row]:g} follows {values[row - 1]:g}; they must not fall"
        raise DataSetError(message, file=file, row=int(lines[row]), column="repetition")
    return values.astype(np.int64)


def check_repetitions(
    t: Float[ndarray, " samples"],
    repetition: Int[ndarray, " samples"] | None,
    entry: RecordingEntry,
    file: str,
) -> None:
    """Hold `repetitions` and `period` of the manifest against the rows."""
    if entry.repetitions is None:
        return
    if repetition is not None and len(np.unique(repetition)) != entry.repetitions:
        message = (
            f"the column holds {counted(len(np.unique(repetition)), 'repetition')}, "
            f"dataset.toml says repetitions = {entry.repetitions}; correct one of them"
        )
        raise DataSetError(message, file=file, column="repetition")
    if entry.period is None:
        return
    # The last sample of whole periods comes at their end or one step before it.
    span = float(t[-1] - t[0] + np.median(np.diff(t)))
    stated = entry.repetitions * entry.period
    slack = 2 * float(np.median(np.diff(t))) + PERIOD_TOLERANCE * stated
    if abs(span - stated) > slack:
        message = (
            f"the time column spans {span:.6g} s, but dataset.toml says {entry.repetitions} "
            f"repetitions x {entry.period:g} s = {stated:.6g} s; correct either, or cut the "
            "recording to whole periods"
        )
        raise DataSetError(message, file=file, column="t")


def derive_repetition(
    t: Float[ndarray, " samples"], repetitions: int, period: float | None
) -> Int[ndarray, " samples"]:
    """Repetition index from time alone, for a recording that holds whole repetitions."""
    if period is None:
        period = float(t[-1] - t[0] + np.median(np.diff(t))) / repetitions
    # A sample that rounding puts just before the end of a period opens the next one.
    phase = (t - t[0]) / period + 1e-6
    return np.minimum(np.floor(phase), repetitions - 1).astype(np.int64)
