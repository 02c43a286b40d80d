"""What a load is to a technician: mass, centre of mass and inertia about it, with 95 % intervals.

The mass is linear in what is estimated, and its interval is Student's. Of the others the interval is the
range of the quantity over the ellipsoid of as many standard deviations about the estimate, that of a
likelihood ratio (Venzon and Moolgavkar 1988, "A method for computing profile-likelihood-based confidence
intervals"). For a centre of mass, a ratio, that is Fieller's, exact for a ratio of normal estimates however
badly the mass is known (Fieller 1954, "Some problems in interval estimation"). Inertia about a centre that
is hardly known is far from linear: a slope at the estimate would say that it is known well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy import stats
from scipy.optimize import root

from oed.robot.inertia import inertia_tensor

LEVEL = 0.95
NAMES = ("mass", "x", "y", "z", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
UNITS = ("kg", *("m",) * 3, *("kg m^2",) * 6)
MOMENTS = (4, 7, 9)  # of these, the ones that cannot be negative
# A derivative below this share of the largest comes from rounding.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Quantity:
    """One number of a load.

    Attributes:
        name: One of `NAMES`; inertia is about the centre of mass, in the axes of the frame.
        unit: Of the number.
        value: Of a body that can exist, next to what the data say.
        interval: At 95 %, without what no body has; None where the data do not bound it.
        is_determined: Whether the interval is narrower than the load itself is large.
    """

    name: str
    unit: str
    value: float
    interval: tuple[float, float] | None
    is_determined: bool


@dataclass(frozen=True)
class LinearEstimate:
    """The ten parameters of a load about its frame, as least squares leave them.

    Attributes:
        parameters: (10,), of which some may be no more than a body's of that mass.
        covariance: (10, 10).
        degrees_of_freedom: (10,) of each one's Student-t interval.
        is_open: (10, k) directions in which no torque depends on them.
    """

    parameters: Float[ndarray, "10"]
    covariance: Float[ndarray, "10 10"]
    degrees_of_freedom: Float[ndarray, "10"]
    is_open: Float[ndarray, "10 open"]

    def reach(self, freedom: float) -> float:
        """Half width of an interval in standard deviations."""
        return float(stats.t.ppf(0.5 + LEVEL / 2, freedom))


def quantities(
    linear: LinearEstimate, body: Float[ndarray, "10"], size: Float[ndarray, "10"]
) -> tuple[Quantity, ...]:
    """The ten numbers of a load.

    Args:
        linear: What the data say.
        body: A body that can exist, next to it.
        size: (10,) of each quantity of the load, which an interval is to be narrower than; moments of
            inertia are larger where the data say so.
    """
    values, slopes = _values(body), _slopes(body)
    intervals = [_interval(linear, slopes[k], k) for k in range(len(NAMES))]
    least = max(size[4], *(low for k in MOMENTS for low, _ in [intervals[k] or (0.0, 0.0)]))
    found = []
    for k, name in enumerate(NAMES):
        interval, width = intervals[k], 2 * (size[k] if k < MOMENTS[0] else least)
        narrow = interval is not None and interval[1] - interval[0] < width
        if interval is not None:
            low, high = min(interval[0], values[k]), max(interval[1], values[k])
            interval = (max(low, 0.0), high) if k == 0 or k in MOMENTS else (low, high)
        found.append(Quantity(name, UNITS[k], float(values[k]), interval, bool(narrow)))
    return tuple(found)


def central_inertia(parameters: Float[ndarray, "10"]) -> Float[ndarray, "3 3"]:
    """Inertia about the centre of mass, in the axes of the frame [kg m^2]."""
    mass, moment = parameters[0], parameters[1:4]
    shift = (moment @ moment * np.eye(3) - np.outer(moment, moment)) / mass
    return inertia_tensor(parameters) - shift


def _values(parameters: Float[ndarray, "10"]) -> Float[ndarray, "10"]:
    centre = parameters[1:4] / parameters[0]
    inertia = central_inertia(parameters)[np.triu_indices(3)]
    return np.concatenate([parameters[:1], centre, inertia])


def _slopes(parameters: Float[ndarray, "10"]) -> Float[ndarray, "10 10"]:
    """Row k holds the derivatives of quantity k by the parameters."""
    mass, moment = parameters[0], parameters[1:4]
    slopes = np.eye(10)
    slopes[1:4, 0] = -moment / mass**2
    slopes[1:4, 1:4] = np.eye(3) / mass
    rows, columns = np.triu_indices(3)
    for k, (i, j) in enumerate(zip(rows.tolist(), columns.tolist(), strict=True)):
        squares = float(moment @ moment) if i == j else 0.0
        slopes[4 + k, 0] = (squares - moment[i] * moment[j]) / mass**2
        if i == j:
            slopes[4 + k, 1:4] -= 2 * moment / mass
        slopes[4 + k, 1 + i] += moment[j] / mass
        slopes[4 + k, 1 + j] += moment[i] / mass
    return slopes


def _interval(
    linear: LinearEstimate, slope: Float[ndarray, "10"], k: int
) -> tuple[float, float] | None:
    across = np.abs(slope @ linear.is_open) if linear.is_open.size else np.zeros(1)
    if across.max() > ROUNDING * np.abs(slope).max():
        return None
    used = np.abs(slope) > ROUNDING * np.abs(slope).max()
    reach = linear.reach(float(linear.degrees_of_freedom[used].min()))
    if 1 <= k <= 3:
        return _ratio_interval(linear, k, reach)
    if k > 0 and linear.parameters[0] <= reach * np.sqrt(linear.covariance[0, 0]):
        return None  # about a centre that is anywhere
    if k == 0:
        half = reach * float(np.sqrt(linear.covariance[0, 0]))
        return float(linear.parameters[0]) - half, float(linear.parameters[0]) + half
    ends = [_end(linear, k, side * reach) for side in (-1.0, 1.0)]
    return (ends[0], ends[1]) if np.isfinite(ends).all() else None


def _end(linear: LinearEstimate, k: int, reach: float) -> float:
    """An end of the range of a central inertia; nan where none is found.

    About a given point inertia is linear, and its end is that of Student's interval. The point is the
    centre of mass of the body at that very end.
    """

    def body_at_end(point: Float[ndarray, "3"]) -> tuple[Float[ndarray, "10"], float]:
        slope = _slopes(np.array([1.0, *point, *(0.0,) * 6]))[k]
        across = linear.covariance @ slope
        deviation = float(np.sqrt(slope @ across))
        body = linear.parameters + reach / deviation * across
        return body, float(slope @ body)

    def missed(point: Float[ndarray, "3"]) -> Float[ndarray, "3"]:
        body, _ = body_at_end(point)
        return body[1:4] / body[0] - point

    found = root(missed, linear.parameters[1:4] / linear.parameters[0])
    return body_at_end(found.x)[1] if found.success else np.nan


def _ratio_interval(linear: LinearEstimate, k: int, reach: float) -> tuple[float, float] | None:
    """Fieller's interval of a first moment over the mass; None where the mass may be zero."""
    mass, moment = linear.parameters[0], linear.parameters[k]
    var = reach**2 * linear.covariance[np.ix_((0, k), (0, k))]
    leading = mass**2 - var[0, 0]
    middle = moment * mass - var[0, 1]
    root = middle**2 - leading * (moment**2 - var[1, 1])
    if leading <= 0 or root < 0:
        return None
    return (
        float((middle - np.sqrt(root)) / leading),
        float((middle + np.sqrt(root)) / leading),
    )
