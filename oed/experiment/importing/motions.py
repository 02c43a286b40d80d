"""Where in a log an arm moves: parted where its clock is set back, and where it stands."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.ndimage import maximum_filter1d, minimum_filter1d

PAUSE = 1.0  # [s] of standstill, or without a row, that parts one motion from the next
STANDSTILL = 0.01  # of the farthest that a joint comes in half a pause
Rows = tuple[int, int]  # first row and the row behind the last, from 0


def find_runs(t: Float[ndarray, " samples"]) -> list[Rows]:
    """Stretches of rows in which the clock is never set back.

    Rows that are only out of order go back by less than a pause, and part nothing.

    Args:
        t: (N,) [s].
    """
    cuts = [0, *(np.flatnonzero(np.diff(t) <= -PAUSE) + 1).tolist(), len(t)]
    return list(itertools.pairwise(cuts))


def is_moving(
    t: Float[ndarray, " samples"], q: Float[ndarray, "samples joints"]
) -> Bool[ndarray, " samples"]:
    """Which rows are of motion, not of a standstill as long as a pause.

    Travel within half a pause tells, not the speed from row to row, which is the encoder's noise
    where a log is fast.

    Args:
        t: (N,) [s].
        q: (N, n) [rad or m].

    Returns:
        (N,); all true where the log has no motion to tell a standstill from.
    """
    step = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    if step <= 0:
        return np.ones(len(t), dtype=bool)
    window = min(len(t), 2 * int(PAUSE / (4 * step)) + 1)
    travel = maximum_filter1d(q, window, axis=0) - minimum_filter1d(q, window, axis=0)
    moving = (travel > STANDSTILL * travel.max(axis=0)).any(axis=1)
    if not moving.any():
        return ~moving
    edges = np.flatnonzero(np.diff(np.concatenate([[0], ~moving, [0]])))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        if t[end - 1] - t[start] < PAUSE:
            moving[start:end] = True
    return moving


def find_motions(t: Float[ndarray, " samples"], moving: Bool[ndarray, " samples"]) -> list[Rows]:
    """Stretches of motion, parted by each standstill and where rows are missing for a pause.

    Args:
        t: (N,) [s].
        moving: (N,) of `is_moving`.
    """
    goes_on = moving[1:] & moving[:-1] & (np.diff(t) < PAUSE)
    starts = np.flatnonzero(moving & ~np.concatenate([[False], goes_on]))
    ends = np.flatnonzero(moving & ~np.concatenate([goes_on, [False]])) + 1
    return list(zip(starts.tolist(), ends.tolist(), strict=True))


def with_rest(t: Float[ndarray, " samples"], motions: Sequence[Rows]) -> list[Rows]:
    """Motions with up to a pause of standstill on either side, as the ends of filters need it.

    Args:
        t: (N,) [s].
        motions: In the order of time; none gets rows that are nearer to another.
    """
    middles = [(end + start) // 2 for (_, end), (start, _) in itertools.pairwise(motions)]
    found = []
    for (start, end), least, most in zip(motions, [0, *middles], [*middles, len(t)], strict=True):
        first, last = np.searchsorted(t, [t[start] - PAUSE, t[end - 1] + PAUSE])
        found.append((max(least, int(first)), min(most, int(last))))
    return found
