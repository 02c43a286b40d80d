"""Interval arithmetic on arrays, enough to run the torque model on ranges of motion.

Every operation returns an interval that contains all results of its operands' members. Results
are widened by a few units in the last place instead of changing the rounding mode.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NoReturn

import numpy as np
from numpy import ndarray

WIDENING = 4 * np.finfo(float).eps  # relative; no operation here errs by more than one unit
Value = ndarray | np.floating  # operations on arrays without dimensions give a scalar


@dataclass(frozen=True, eq=False)
class Interval:
    """Lower and upper bounds, (N,) each.

    Attributes:
        lower: Bounds from below.
        upper: Bounds from above.
    """

    lower: ndarray
    upper: ndarray

    def __add__(self, other: object) -> Interval:
        a = _interval(other)
        return _widened(self.lower + a.lower, self.upper + a.upper)

    def __sub__(self, other: object) -> Interval:
        return self + (-_interval(other))

    def __neg__(self) -> Interval:
        return _between(-self.upper, -self.lower)

    def __mul__(self, other: object) -> Interval:
        a = _interval(other)
        products = (
            self.lower * a.lower,
            self.lower * a.upper,
            self.upper * a.lower,
            self.upper * a.upper,
        )
        return _widened(np.minimum.reduce(products), np.maximum.reduce(products))

    def __truediv__(self, other: object) -> Interval:
        a = _interval(other)
        if np.any((a.lower <= 0) & (a.upper >= 0)):
            raise NotImplementedError("division by an interval that contains zero")
        return self * _widened(1 / a.upper, 1 / a.lower)

    def __pow__(self, exponent: float) -> Interval:
        return _power(self, _interval(exponent))

    def __radd__(self, other: object) -> Interval:
        return self + other

    def __rsub__(self, other: object) -> Interval:
        return _interval(other) - self

    def __rmul__(self, other: object) -> Interval:
        return self * other

    def __rtruediv__(self, other: object) -> Interval:
        return _interval(other) / self

    def _refuse(self, *_: object, **__: object) -> NoReturn:
        """An interval is neither an array of numbers nor on one side of a threshold."""
        raise NotImplementedError("comparing or indexing an interval")

    __lt__ = __le__ = __gt__ = __ge__ = __getitem__ = __array__ = _refuse

    def __array_ufunc__(
        self, ufunc: np.ufunc, method: str, *inputs: object, **_: object
    ) -> Interval:
        """What NumPy calls for np.sin(interval) and array * interval."""
        if method != "__call__" or ufunc not in OPERATIONS:
            raise NotImplementedError(f"{ufunc.__name__} of an interval")
        return OPERATIONS[ufunc](*(_interval(x) for x in inputs))


def _interval(value: object) -> Interval:
    if isinstance(value, Interval):
        return value
    number = np.asarray(value, dtype=float)
    return Interval(number, number)


def _between(lower: Value, upper: Value) -> Interval:
    return Interval(np.asarray(lower), np.asarray(upper))


def _widened(lower: Value, upper: Value) -> Interval:
    slack = WIDENING * np.maximum(np.abs(lower), np.abs(upper))
    return _between(lower - slack, upper + slack)


def _increasing(function: Callable[[ndarray], ndarray]) -> Callable[[Interval], Interval]:
    return lambda a: _widened(function(a.lower), function(a.upper))


def _sin(a: Interval) -> Interval:
    ends = np.sin(a.lower), np.sin(a.upper)
    # A crest lies at pi/2 + 2 pi k, a trough at -pi/2 + 2 pi k; the margin covers rounding.
    margin = WIDENING * (1 + np.maximum(np.abs(a.lower), np.abs(a.upper)))

    def holds(phase: float) -> ndarray:
        first = np.ceil((a.lower - margin - phase) / (2 * np.pi))
        return 2 * np.pi * first + phase <= a.upper + margin

    lower = np.where(holds(-np.pi / 2), -1.0, np.minimum(*ends))
    upper = np.where(holds(np.pi / 2), 1.0, np.maximum(*ends))
    return _widened(lower, upper)


def _cos(a: Interval) -> Interval:
    return _sin(a + np.pi / 2)


def _abs(a: Interval) -> Interval:
    largest = np.maximum(np.abs(a.lower), np.abs(a.upper))
    smallest = np.maximum(np.maximum(a.lower, -a.upper), 0.0)
    return _between(smallest, largest)


def _power(a: Interval, exponent: Interval) -> Interval:
    """A constant power; a broken one of what rounding put below zero is that of zero."""
    power = exponent.lower
    if power.size != 1 or not np.array_equal(power, exponent.upper):
        raise NotImplementedError("power of an interval with an exponent that varies")
    e = float(power.reshape(-1)[0])
    is_whole = e == np.round(e)
    if is_whole and e % 2 == 0:
        a = _abs(a)
    elif not is_whole:
        a = _between(np.maximum(a.lower, 0.0), np.maximum(a.upper, 0.0))
    if e < 0 and np.any((a.lower <= 0) & (a.upper >= 0)):
        raise NotImplementedError("negative power of an interval that contains zero")
    ends = a.lower**e, a.upper**e
    return _widened(np.minimum(*ends), np.maximum(*ends))


OPERATIONS: dict[np.ufunc, Callable[..., Interval]] = {
    np.add: lambda a, b: a + b,
    np.subtract: lambda a, b: a - b,
    np.multiply: lambda a, b: a * b,
    np.divide: lambda a, b: a / b,
    np.negative: lambda a: -a,
    np.power: _power,
    np.sin: _sin,
    np.cos: _cos,
    np.absolute: _abs,
    np.tanh: _increasing(np.tanh),
    np.exp: _increasing(np.exp),
    np.sign: lambda a: _between(np.sign(a.lower), np.sign(a.upper)),
}
