"""Torques that hardly any sensor can have measured: held values, and single leaps.

A logger that starts before the drive reports, or a bus that drops messages, writes the same
torque row after row while the joint moves on; a broken message is one wild value between two that
agree. Either passes for physics: zeros for the first seconds are a load that is taken up after
them, and one wild value outweighs a thousand others in a sum of squares. Only whoever made the log
can tell: an arm that swings with its drives off has no torque either.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

# [s] and rows for which a torque stays the same, and times what it usually does, where a sensor's
# steps or a slower sensor may hold it.
HELD = 0.3
HELD_ROWS = 20
HELD_LONGER = 20.0
MOVED = 0.02  # of a joint's travel that it moves meanwhile
LEVELS = 200  # between the ends of the range of torque: with fewer it stays on one for long
AT_LIMIT = 0.01  # of the range of torque, within which of its ends a held value is a drive's limit
# Of its range of torque by which a value is away from the ones before and after it, and share of that
# by which these may differ: a blow lasts, and a joint that turns ends at another torque.
LEAP = 0.3
AGREE = 0.1
RESTS = 0.02  # of a joint's usual speed, below which it may stand
USUAL = 0.99  # of the rows, whose torque is its range
FEW = 0.002  # of the rows; what leaps more often is how that torque is


def torque_fault_notes(
    t: Float[ndarray, " samples"],
    q: Float[ndarray, "samples joints"],
    tau: Float[ndarray, "samples joints"],
    file: str,
    lines: Int[ndarray, " samples"],
) -> Iterator[str]:
    """A line for torques that are held while their joints move, and for each that leaps.

    Args:
        t: (N,) [s].
        q: (N, n) [rad or m].
        tau: (N, n) [N m or N].
        file: For the message.
        lines: (N,) line of the file that each sample is of.
    """
    held: dict[tuple[int, int, float], list[str]] = {}
    for j in range(tau.shape[1]):
        longest = max(
            _held(t, q[:, j], tau[:, j]), key=lambda rows: t[rows[1]] - t[rows[0]], default=None
        )
        if longest is not None:
            held.setdefault((*longest, float(tau[longest[0], j])), []).append(f"'tau_{j + 1}'")
    for (start, end, value), columns in held.items():
        why = "right only with the drive off" if value == 0 else "the sensor did not report"
        yield (
            f"{file}, rows {lines[start]} to {lines[end]}, column {', '.join(columns)}: stays at "
            f"{value:.4g} for {t[end] - t[start]:.3g} s while the joint moves: {why}; else cut these rows, "
            "which pass for a load or an offset"
        )
    for j in range(tau.shape[1]):
        leaps = np.flatnonzero(_leaps(q[:, j], tau[:, j]))
        if len(leaps):
            row = int(leaps[np.argmax(np.abs(tau[leaps, j]))])
            before, value, after = tau[row - 1 : row + 2, j]
            more = f", and {len(leaps) - 1} more such rows" if len(leaps) > 1 else ""
            yield (
                f"{file}, row {lines[row]}, column 'tau_{j + 1}': {value:.4g} between {before:.4g} and "
                f"{after:.4g}{more}: one wild value outweighs all others; remove it from the log"
            )


def _held(
    t: Float[ndarray, " samples"], q: Float[ndarray, " samples"], tau: Float[ndarray, " samples"]
) -> Iterator[tuple[int, int]]:
    """First and last row of stretches in which a torque stays the same for long."""
    steps = np.abs(np.diff(tau))
    edges = np.flatnonzero(steps) + 1
    if not len(edges) or np.ptp(tau) < LEVELS * steps[edges - 1].min():
        return
    first, last = np.append(0, edges), np.append(edges, len(tau)) - 1
    rows = last - first + 1
    long = (rows >= max(HELD_ROWS, HELD_LONGER * np.median(rows))) & (t[last] - t[first] >= HELD)
    margin = AT_LIMIT * np.ptp(tau)
    inside = (tau[first] > tau.min() + margin) & (tau[first] < tau.max() - margin)
    inside |= tau[first] == 0
    for start, end in zip(first[long & inside], last[long & inside], strict=True):
        if np.ptp(q[start : end + 1]) > MOVED * np.ptp(q):
            yield int(start), int(end)


def _leaps(
    q: Float[ndarray, " samples"], tau: Float[ndarray, " samples"]
) -> Bool[ndarray, " samples"]:
    """Single rows far away from both neighbours, which agree, while the joint moves."""
    low, high = np.quantile(tau, [1 - USUAL, USUAL])
    before, after = tau[1:-1] - tau[:-2], tau[1:-1] - tau[2:]
    away = np.minimum(np.abs(before), np.abs(after))
    leaps = (away > LEAP * (high - low)) & (np.abs(before - after) < AGREE * away)
    # Between two moves a joint may rest for no more than one row, without its friction.
    travel = np.abs(q[2:] - q[:-2])
    leaps &= travel > RESTS * np.sqrt(np.mean(travel**2))
    result = np.zeros(len(tau), dtype=bool)
    result[1:-1] = leaps & (np.mean(leaps) <= FEW)
    return result
