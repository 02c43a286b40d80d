"""Whether a recorded motion repeats itself, and how fast."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import correlate

POINTS = 4000  # at which a motion is compared with itself
SHORTEST = 1.0  # [s] period of a motion that excites an arm
LEAST_PERIODS = 3  # of which a log must hold so many to count as repetitions
# Departure of a period from the next, over the rms of the motion: arms track within a per cent or so,
# and other motions differ by 100 % and more.
SAME = 0.05
DIFFERENT = 0.5


def find_period(t: Float[ndarray, " samples"], q: Float[ndarray, "samples joints"]) -> float | None:
    """The period of a motion that repeats at least three times.

    Args:
        t: (N,) [s].
        q: (N, n) positions [rad or m].

    Returns:
        The period [s]; None where the motion does not repeat.
    """
    if len(t) < 2 or t[-1] - t[0] < LEAST_PERIODS * SHORTEST or not (np.diff(t) > 0).all():
        return None
    grid = np.linspace(t[0], t[-1], min(POINTS, len(t)))
    step = float(grid[1] - grid[0])
    x = np.column_stack([np.interp(grid, t, column) for column in q.T])
    x -= x.mean(axis=0)
    power = np.mean(x**2, axis=0)
    x = x[:, power > 0] / np.sqrt(power[power > 0])
    if not x.shape[1]:
        return None
    departure = _departure(x)
    first, last = int(np.ceil(SHORTEST / step)), int(len(grid) / LEAST_PERIODS) + 1
    others = np.flatnonzero(departure > DIFFERENT)
    if not others.size:
        return None
    # The shortest lag at which the motion is the same, after it has become another one.
    lags = np.arange(max(first, int(others[0])), last)
    same = lags[departure[lags] < SAME]
    if not same.size:
        return None
    lag = _lowest(departure, int(same[0]))
    count = int((len(grid) - 1) / lag + 0.01)
    if count < LEAST_PERIODS:
        return None
    return _refined(departure, lag, count) * step


def _departure(x: Float[ndarray, "points joints"]) -> Float[ndarray, " lags"]:
    """Rms difference of a motion of unit power from itself, by lag in points."""
    points, joints = x.shape
    total = np.zeros(points)
    for column in x.T:
        product = correlate(column, column, method="fft")[points - 1 :]
        squares = np.cumsum(column**2)
        head = squares[::-1]
        tail = squares[-1] - np.concatenate([[0.0], squares[:-1]])
        total += head + tail - 2 * product
    overlap = points - np.arange(points)
    return np.sqrt(np.maximum(total, 0.0) / (overlap * joints))


def _lowest(departure: Float[ndarray, " lags"], start: int) -> int:
    """The minimum of the valley that begins at `start`."""
    end = start
    while end + 1 < len(departure) and departure[end + 1] < SAME:
        end += 1
    return start + int(np.argmin(departure[start : end + 1]))


def _refined(departure: Float[ndarray, " lags"], lag: int, count: int) -> float:
    """The lag to a fraction of a point, by the minimum at the most periods that overlap well."""
    best = float(lag)
    for periods in range(1, count):
        centre = round(best * periods)
        around = np.arange(max(1, centre - 3), min(len(departure) - 1, centre + 4))
        i = int(around[np.argmin(departure[around])])
        before, here, after = departure[i - 1 : i + 2] ** 2
        bend = before - 2 * here + after
        shift = 0.5 * (before - after) / bend if bend > 0 else 0.0
        best = (i + float(np.clip(shift, -0.5, 0.5))) / periods
    return best
