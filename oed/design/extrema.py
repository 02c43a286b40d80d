"""Proven extrema of a motion over its whole horizon, by branch and bound.

On an interval of half width h about m, a function f with |f''| <= M everywhere obeys
|f(t) - f(m)| <= |f'(m)| h + M h^2 / 2. Intervals that this bound cannot rule out are split
until bound and largest value found agree; what is returned is the bound, never the sample.
Piecewise polynomials are bounded by their coefficients instead.
"""

from __future__ import annotations

import itertools

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.joint_sums import JointSums
from oed.design.piecewise_extrema import bernstein_range
from oed.design.trajectories import TrajectoryClass

TOLERANCE = 1e-7  # of a joint's own scale, between proven bound and attained value
# Of a first sweep, and parts of each that may hold the extremum: what is proven holds for any number,
# and only the time depends on it.
FIRST_INTERVALS = 128
QUICK_INTERVALS = 512  # of the one sweep of `quick_range`, which splits nothing further
QUICK_TOLERANCE = 1e-4  # of `quick_range` where there are pieces, as `TOLERANCE`
SPLIT = 4
# Rounding of a sum of sines, relative to the sum of their magnitudes: a thousand times the unit.
ROUNDING = 1e-13
DEPTH = 40  # halvings by four beyond which doubles cannot split an interval any more


def proven_range(
    trajectory: TrajectoryClass | JointSums,
    z: Float[ndarray, " size"],
    order: int,
    *,
    tolerance: float = TOLERANCE,
) -> Float[ndarray, "joints 2"]:
    """Bounds that a derivative of position never leaves, for all t in the horizon.

    Args:
        trajectory: The class, or sums over the joints of one, which stand for joints then.
        z: The motion.
        order: 0 position, 1 velocity, 2 acceleration, 3 jerk.
        tolerance: How far the bounds may lie beyond the extrema, relative to the sum of the
            magnitudes of the joint's terms.

    Returns:
        (n, 2) lower bound on the minimum and upper bound on the maximum.
    """
    scale = trajectory.derivative_bound(z, order)
    pieces = trajectory.bernstein(z, order)
    if pieces is not None:
        return _range_of_pieces(pieces, scale, tolerance)
    curvature = trajectory.derivative_bound(z, order + 2)
    middle, half = first_intervals(trajectory)
    attained = np.stack([np.full(len(scale), np.inf), np.full(len(scale), -np.inf)])
    proven = attained.copy()
    gap = tolerance * scale
    for level in range(DEPTH):
        value = trajectory.derivative(z, middle, order)
        slope = np.abs(trajectory.derivative(z, middle, order + 1))
        reach = slope * half[:, None] + curvature * half[:, None] ** 2 / 2
        attained[0] = np.minimum(attained[0], value.min(axis=0))
        attained[1] = np.maximum(attained[1], value.max(axis=0))
        is_open = (value - reach < attained[0] - gap) | (value + reach > attained[1] + gap)
        split = is_open.any(axis=1)
        if level == DEPTH - 1:
            split[:] = False
        _widen(proven, (value - reach)[~split], (value + reach)[~split])
        if not split.any():
            break
        middle, half = split_intervals(middle[split], half[split])
    slack = ROUNDING * (scale + np.abs(attained).max(axis=0))
    centre = trajectory.centre(z) if order == 0 else 0.0
    lower, upper = np.maximum(proven[0], centre - scale), np.minimum(proven[1], centre + scale)
    return np.stack([lower - slack, upper + slack], axis=1)


def quick_range(
    trajectory: TrajectoryClass | JointSums, z: Float[ndarray, " size"], order: int
) -> Float[ndarray, "joints 2"]:
    """Proven bounds from one sweep of samples: wider than `proven_range`, many times faster.

    At an extremum inside the horizon the next derivative is zero, so a sample within h of it
    lies within M h^2 / 2 of the extreme value; the ends are samples themselves.
    """
    pieces = trajectory.bernstein(z, order)
    if pieces is not None:
        return _range_of_pieces(pieces, trajectory.derivative_bound(z, order), QUICK_TOLERANCE)
    ends = trajectory.breakpoints
    nodes = [np.linspace(a, b, QUICK_INTERVALS + 1) for a, b in itertools.pairwise(ends)]
    half = np.diff(ends).max() / QUICK_INTERVALS / 2
    values = trajectory.derivative(z, np.concatenate(nodes), order)
    slack = trajectory.derivative_bound(z, order + 2) * half**2 / 2
    slack = slack + ROUNDING * (trajectory.derivative_bound(z, order) + np.abs(values).max(axis=0))
    return np.stack([values.min(axis=0) - slack, values.max(axis=0) + slack], axis=1)


def _range_of_pieces(
    pieces: Float[ndarray, "pieces coefficients joints"],
    scale: Float[ndarray, " joints"],
    tolerance: float,
) -> Float[ndarray, "joints 2"]:
    proven = bernstein_range(pieces, tolerance * scale)
    slack = ROUNDING * (scale + np.abs(pieces).max(axis=(0, 1)))
    return np.stack([proven[:, 0] - slack, proven[:, 1] + slack], axis=1)


def first_intervals(trajectory: TrajectoryClass | JointSums) -> tuple[ndarray, ndarray]:
    """Middles and half widths of intervals that no breakpoint lies within."""
    ends = np.asarray(trajectory.breakpoints)
    counts = np.ceil(FIRST_INTERVALS * np.diff(ends) / (ends[-1] - ends[0])).astype(int)
    edges = [
        np.linspace(a, b, count + 1)
        for (a, b), count in zip(itertools.pairwise(ends), counts, strict=True)
    ]
    middle = np.concatenate([(edge[1:] + edge[:-1]) / 2 for edge in edges])
    half = np.concatenate([np.diff(edge) / 2 for edge in edges])
    return middle, half


def split_intervals(middle: ndarray, half: ndarray) -> tuple[ndarray, ndarray]:
    """Middles and half widths of each interval's `SPLIT` equal parts."""
    parts = (np.arange(SPLIT) * 2 + 1 - SPLIT) / SPLIT
    return (middle[:, None] + half[:, None] * parts).reshape(-1), np.repeat(half / SPLIT, SPLIT)


def _widen(proven: ndarray, lower: ndarray, upper: ndarray) -> None:
    if len(lower):
        proven[0] = np.minimum(proven[0], lower.min(axis=0))
        proven[1] = np.maximum(proven[1], upper.max(axis=0))
