"""B-splines at one instant, symbolic or in numbers: every polynomial piece, of which one counts."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.interpolate import BSpline, PPoly

from oed.dynamics.scalars import Scalar, add, at_least, mul, sub, within


def spline_values(
    knots: Float[ndarray, " knots"], degree: int, x: Scalar, *, derivative: int = 0
) -> list[Scalar]:
    """All basis functions, or their derivatives, at a place; beyond the knots they stay.

    Args:
        knots: With the first and last repeated.
        degree: Of the pieces.
        x: The place.
        derivative: Of which order.
    """
    functions = len(knots) - degree - 1
    units = (PPoly.from_spline(BSpline(knots, own, degree)) for own in np.eye(functions))
    pieces = [unit.derivative(derivative) for unit in units]
    edges = pieces[0].x
    lengths = np.diff(edges)
    first, last = np.flatnonzero(lengths > 0)[[0, -1]]
    inside = within(x, float(knots[0]), float(knots[-1]))
    values: list[Scalar] = [0.0] * functions
    for k in np.flatnonzero(lengths > 0):
        begun = 1.0 if k == first else at_least(inside, float(edges[k]))
        over = 0.0 if k == last else at_least(inside, float(edges[k + 1]))
        here, way = sub(begun, over), inside - float(edges[k])
        for i in range(functions):
            coefficients = pieces[i].c[:, k]
            if coefficients.any():
                values[i] = add(values[i], mul(here, _polynomial(coefficients, way)))
    return values


def _polynomial(coefficients: Float[ndarray, " order"], x: Scalar) -> Scalar:
    value: Scalar = 0.0
    for c in coefficients.tolist():
        value = add(mul(value, x), c)
    return value
