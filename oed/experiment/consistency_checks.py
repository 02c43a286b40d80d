"""Whether the columns of a recording agree with one another: units, joints, repetitions."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.errors import DataSetError
from oed.experiment.recording_checks import BEYOND_LIMITS
from oed.experiment.signals.gaps import find_gaps
from oed.robot import Robot

TELLING_TRAVEL = 0.05  # [rad or m] a joint that is held drifts less; what it logs tells nothing
WINDOWS = 100  # over which position and velocity are compared: a drive's delay is lost in each
# Measured logs give 0.98 to 1.02, a wrong unit 57 or more, another joint's velocity anything.
VELOCITY_RATIO = 2.0
SAME = 0.1  # relative distance at which a ratio is taken for a known one
CAUSES = (
    (180 / np.pi, "dq looks like degrees per second; convert it to rad/s"),
    (np.pi / 180, "q looks like degrees; convert it to rad"),
    (1e3, "t looks like milliseconds, or dq like mm/s; convert to s and m/s"),
    (1e-3, "dq looks as if per millisecond, or q like mm; convert to rad/s or m"),
    (1e6, "t looks like microseconds; convert it to s"),
    (1e9, "t looks like nanoseconds; convert it to s"),
    (-1.0, "its sign is reversed"),
)
SPEED_STEP = 0.02  # [s] over which speeds are taken: encoder steps are lost in the motion
SPEEDING = 0.1  # share of a recording that a joint cannot be far beyond its velocity limit
PHASES = 200  # at which repetitions are compared
# Departure of a repetition from their mean, over the rms of the motion: arms repeat within a few
# per cent even where they track badly; parts that are no repetitions differ by 70 % and more.
LARGEST_DEPARTURE = 0.3


def check_velocity(
    t: Float[ndarray, " samples"],
    q: Float[ndarray, "samples joints"],
    dq: Float[ndarray, "samples joints"],
    robot: Robot,
    file: str,
) -> None:
    """Refuse a logged velocity that is not the slope of the position over time.

    Args:
        t: (N,) [s].
        q: (N, n) [rad or m].
        dq: (N, n) [rad/s or m/s].
        robot: For the joints' names.
        file: For the message.

    Raises:
        DataSetError: Naming the joint, the ratio and its likely cause.
    """
    steps = np.diff(t)[:, None]
    travelled = np.concatenate(
        [np.zeros_like(dq[:1]), np.cumsum((dq[1:] + dq[:-1]) / 2 * steps, 0)]
    )
    edges = np.linspace(0, len(t) - 1, min(WINDOWS, len(t) - 1) + 1).astype(int)
    has_gap = np.isin(np.arange(len(steps)), find_gaps(t, np.inf))
    whole = ~np.logical_or.reduceat(has_gap, edges[:-1])
    moved, integral = np.diff(q[edges], axis=0)[whole], np.diff(travelled[edges], axis=0)[whole]
    for j in np.flatnonzero(_telling(q)):
        ratios = [_slope(moved[:, j], column) for column in integral.T]
        if 1 / VELOCITY_RATIO < ratios[j] < VELOCITY_RATIO:
            continue
        message = (
            f"velocity is {ratios[j]:.4g} times the slope of q_{j + 1} over t (joint "
            f"{robot.joints[j].name!r}): {_cause(ratios, int(j))}; correct the log, or leave dq "
            "out (oed import --columns dq=)"
        )
        raise DataSetError(message, file=file, column=f"dq_{j + 1}")


def check_speed(
    t: Float[ndarray, " samples"], q: Float[ndarray, "samples joints"], robot: Robot, file: str
) -> None:
    """Refuse positions (N, n) that move so far beyond the velocity limits that a unit is wrong."""
    stride = min(len(t) - 1, max(1, round(SPEED_STEP / float(np.median(np.diff(t))))))
    speed = np.abs(q[stride:] - q[:-stride]) / (t[stride:] - t[:-stride])[:, None]
    limit = np.abs(robot.limits.velocity).max(axis=1)
    speeding = np.mean(speed > BEYOND_LIMITS * limit, axis=0)
    for j in np.flatnonzero(speeding > SPEEDING):
        typical = float(np.quantile(speed[:, j], 1 - SPEEDING))
        message = (
            f"joint {robot.joints[j].name!r} moves at {typical:.4g} and more in "
            f"{100 * SPEEDING:g} % of the recording, {typical / limit[j]:.3g} times its velocity "
            f"limit of {limit[j]:.4g}: q is not in rad or m, t not in s, or the limit is a "
            "placeholder; convert them, or state [limits] velocity in dataset.toml"
        )
        raise DataSetError(message, file=file, column=f"q_{j + 1}")


def check_repeats(
    t: Float[ndarray, " samples"],
    q: Float[ndarray, "samples joints"],
    repetition: Int[ndarray, " samples"],
    period: float | None,
    file: str,
) -> None:
    """Refuse repetitions that do not repeat in q.

    Args:
        t: (N,) [s].
        q: (N, n) [rad or m].
        repetition: (N,) index of each row's repetition, never falling.
        period: At which repetitions begin [s]; None where each begins at its first row.
        file: For the message.

    Raises:
        DataSetError: Naming the joint and the repetition that departs most.
    """
    _, first = np.unique(repetition, return_index=True)
    starts = t[first] if period is None else t[0] + period * np.arange(len(first))
    lengths = np.append(t[first[1:]], t[-1]) - starts
    # One that was broken off would leave little to compare.
    long = lengths > 0.5 * np.median(lengths)
    if long.sum() < 2:
        return
    phase = np.linspace(0.0, lengths[long].min(), PHASES)
    instants = starts[long][:, None] + phase
    for j in np.flatnonzero(_telling(q)):
        folded = np.interp(instants, t, q[:, j])
        departure = np.sqrt(np.mean((folded - folded.mean(axis=0)) ** 2, axis=1)) / folded.std()
        worst = int(departure.argmax())
        if departure[worst] > LARGEST_DEPARTURE:
            message = (
                f"repetition {np.flatnonzero(long)[worst]} departs from the mean of "
                f"{len(departure)} by {100 * departure[worst]:.0f} % of the motion's rms: the "
                "motion does not repeat as stated; correct repetitions and period in "
                "dataset.toml or the column repetition, or leave them out"
            )
            raise DataSetError(message, file=file, column=f"q_{j + 1}")


def _telling(q: Float[ndarray, "samples joints"]) -> Bool[ndarray, " joints"]:
    return np.ptp(q, axis=0) > TELLING_TRAVEL


def _slope(x: Float[ndarray, " windows"], y: Float[ndarray, " windows"]) -> float:
    """The a that minimises sum |y - a x|: the median of y / x weighted by |x|."""
    x, y = x[x != 0], y[x != 0]
    if not len(x):
        return 1.0  # nothing is known against it
    with np.errstate(over="ignore"):  # of an x that is next to nothing, and weighs as little
        ratio = y / x
    order = np.argsort(ratio)
    weight = np.cumsum(np.abs(x[order]))
    return float(ratio[order[np.searchsorted(weight, weight[-1] / 2)]])


def _cause(ratios: list[float], joint: int) -> str:
    """What makes the velocity of `joint` fit badly, given every velocity's ratio to its position."""
    if ratios[joint] == 0:
        return "it was not logged"
    for known, cause in CAUSES:
        if abs(ratios[joint] / known - 1) < SAME:
            return cause
    others = [k for k, ratio in enumerate(ratios) if abs(ratio - 1) < SAME]
    if others:
        return f"dq_{others[0] + 1} fits this joint; the columns are exchanged"
    return "it is of another joint, or of the motor before the gear"
