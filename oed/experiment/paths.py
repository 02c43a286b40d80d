"""Where a motion goes along the path of another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.spatial import cKDTree

STEP = 0.05  # [s] from one place of a path to the next
LOOKS = (0, 2, 4)  # steps at which positions are compared: where an arm is, and how it moves on
STANDS = 1e-4  # of the ranges: an arm that moves less in a step


def steps_apart(
    held: Float[ndarray, "rows joints"], others: Sequence[Float[ndarray, "_ joints"]], rate: float
) -> Float[ndarray, " rows"]:
    """How far each place of a motion is from the paths of others, in units of its own next step.

    A place of a path is the positions of all joints at several moments after one another, each over
    its range. Up to one, an arm moves where, and as, it did in the others.

    Args:
        held: Positions at equal steps in time.
        others: The same of other motions.
        rate: Of the rows [Hz].

    Returns:
        (rows,) NaN where the arm stands, and at the end, where nothing says how it moves on; infinite
        where there is no other motion.
    """
    stride = max(1, round(STEP * rate))
    own = _places(held, stride)
    there = [x for x in (_places(q, stride) for q in others) if len(x)]
    result = np.full(len(held), np.nan)
    if len(own) <= stride:
        return result
    every = np.concatenate([*there, own])
    ranges = np.ptp(every, axis=0)
    scale = np.where(ranges > 0, ranges, 1.0)
    step = np.linalg.norm((own[stride:] - own[:-stride]) / scale, axis=1)
    distance = np.full(len(step), np.inf)
    if there:
        distance, _ = cKDTree(np.concatenate(there) / scale).query(own[:-stride] / scale)
    moves = step > STANDS
    result[: len(step)][moves] = distance[moves] / step[moves]
    return result


def _places(positions: Float[ndarray, "rows joints"], stride: int) -> Float[ndarray, "places q"]:
    """Positions of all joints at every row, and some steps after it."""
    last = len(positions) - max(LOOKS) * stride
    if last < 1:
        return np.zeros((0, positions.shape[1] * len(LOOKS)))
    return np.hstack([positions[k * stride : last + k * stride] for k in LOOKS])
