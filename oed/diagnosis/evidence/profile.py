"""How far a shape may move before the fit is clearly worse: its profile likelihood.

The secants of a shape hold the sizes where they are. Where a shape and a size trade places along a
curved valley, a fit with all else free again stays good much further than any slope tells: the
deviation is then half the distance at which twice the log likelihood has fallen by four (Bates and
Watts 1988, Nonlinear Regression Analysis and Its Applications, ch. 6).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.optimize import root_scalar

from oed.diagnosis.terms.secants import secants
from oed.diagnosis.terms.trials import Trial, dense, moved
from oed.diagnosis_new.noise.linear_fit import Projection, project
from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.dynamics.effects.catalogue import CATALOGUE, Context

REACH = 2.0  # deviations at which a fit is compared
ABOUT = 4  # deviations within which the bottom of a profile is looked for
LEAST_REACH = 1.0  # deviations that must lie inside the shape's range
UNIFORM = 1 / np.sqrt(12)  # deviation of a shape of which nothing is known, of its range
SETTLED = 0.05  # relative error of a deviation that does not matter


def left_by(
    trial: Trial,
    others: Projection,
    target: Float[ndarray, "joints rows"],
    rows: Rows,
    context: Context,
    *,
    steps: Float[ndarray, " shapes"],
) -> Callable[[int, float], float]:
    """White sum of squares by place of a shape and its axis, all else fitted anew.

    Args:
        trial: An addition, on the rows of the layout.
        others: Projection on the columns of all else.
        target: What these and the addition explain.
        rows: White rows.
        context: Rebuilds the addition.
        steps: Over which the slopes of its other shapes are taken.
    """
    shapes = CATALOGUE[trial.name].shapes_for(context, trial.target)

    def squares(place: int, axis: float) -> float:
        values = list(trial.values)
        values[place] = shapes[place].at(axis)
        own = moved(dataclasses.replace(trial, values=tuple(values)), rows, context)
        columns = dense(own, *target.shape)
        y, free = others.residual(target), []
        if own.fixed:
            y = y - others.residual(columns.sum(axis=2))
            sizes = np.ones(columns.shape[2], dtype=float)
        else:
            free = [others.outside(columns)]
            span = project(free[0])
            sizes = span.inverse @ span.coordinates(y)
        slopes = np.delete(secants(own, sizes, rows, context, steps), place, axis=2)
        whole = np.concatenate([*free, others.outside(slopes)], axis=2)
        return float(np.sum((project(whole).residual(y) if whole.shape[2] else y) ** 2))

    return squares


def profiled_deviation(
    squares: Callable[[float], float], axis: float, deviation: float, noise: float
) -> float:
    """Deviation of a shape on its axis: the given one, or as wide as its profile.

    Of a shape beside the profile's bottom it is wider by how far that is.

    Args:
        squares: White sum of squares by the shape's axis, all else fitted anew.
        axis: Estimate.
        deviation: As its slope has it.
        noise: What counts as one in the squares: that of a row and of its neighbours.
    """
    best = _least_about(squares, axis, deviation)

    def slack(deviation: float) -> float:
        """By how much the worse of two sides falls faster than a parabola, negative if slower."""
        slacks = [1.0]
        for side in (-1.0, 1.0):
            there = float(np.clip(axis + side * REACH * deviation, 0.0, 1.0))
            reach = abs(there - axis) / deviation
            if reach >= LEAST_REACH:
                fall = max(squares(there) - best, 0.0) / noise
                slacks.append(np.sqrt(fall) / reach - 1)
        return float(min(slacks))

    if slack(deviation) >= -SETTLED:
        return deviation
    lower, upper = deviation, min(2 * deviation, UNIFORM)
    while slack(upper) < 0:
        if upper >= UNIFORM:
            return UNIFORM
        lower, upper = upper, min(2 * upper, UNIFORM)
    return float(root_scalar(slack, bracket=(lower, upper), rtol=SETTLED).root)


def _least_about(squares: Callable[[float], float], axis: float, deviation: float) -> float:
    """Least squares within a few deviations: a shape that two motions decided is none of one's."""
    here = squares(axis)
    for side in (-1.0, 1.0):
        for count in range(1, ABOUT + 1):
            there = squares(float(np.clip(axis + side * count * deviation, 0.0, 1.0)))
            if there >= here:
                break
            here = there
    return here


def widened(
    covariance: Float[ndarray, "columns columns"], place: int, ratio: float
) -> Float[ndarray, "columns columns"]:
    """Covariance with one parameter's deviation so many times as large, others going with it."""
    own = covariance[:, place]
    return covariance + (ratio**2 - 1) * np.outer(own, own) / own[place]


def axes_of(trial: Trial, context: Context) -> list[tuple[int, float]]:
    """Which shapes of an addition have a range and are no choice, and where they lie in it."""
    shapes = CATALOGUE[trial.name].shapes_for(context, trial.target)
    places = enumerate(zip(trial.values, shapes, strict=True))
    return [
        (k, s.place_of(v))
        for k, (v, s) in places
        if s.is_estimated and s.upper > s.lower and not s.is_plain(v)
    ]
