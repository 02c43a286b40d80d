"""Three-vectors of scalars that may be floats, (N,) arrays or CasADi expressions.

The dynamics are written once, in components. A product with an exact zero is the
float 0.0 and disappears, so a robot's structural zeros cost nothing, neither in an
array sweep nor in an expression graph.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from types import ModuleType
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

Scalar = Any  # float | Float[ndarray, " samples"] | casadi.SX
Vector = tuple[Scalar, Scalar, Scalar]
Matrix = tuple[Vector, Vector, Vector]  # rows

ZERO: Vector = (0.0, 0.0, 0.0)
STILL = 1e-6  # change of a velocity over a step, as a share of it, that is none


def is_zero(a: Scalar) -> bool:
    """Whether `a` is the structural zero, not merely an expression that may vanish."""
    return isinstance(a, float) and bool(a == 0.0)


def _symbolic(a: Scalar) -> ModuleType | None:
    """CasADi where `a` is an expression of it, else none: who has no expression need not load it."""
    casadi = sys.modules.get("casadi")
    return casadi if casadi is not None and isinstance(a, casadi.SX) else None


def add(a: Scalar, b: Scalar) -> Scalar:
    """Sum a + b."""
    if is_zero(a):
        return b
    return a if is_zero(b) else a + b


def sub(a: Scalar, b: Scalar) -> Scalar:
    """Difference a - b."""
    if is_zero(b):
        return a
    return -b if is_zero(a) else a - b


def mul(a: Scalar, b: Scalar) -> Scalar:
    """Product a b."""
    if isinstance(a, float):
        if a == 0.0 or is_zero(b):
            return 0.0
        return b if a == 1.0 else a * b
    if isinstance(b, float):
        if b == 0.0:
            return 0.0
        return a if b == 1.0 else a * b
    return a * b


def total(terms: Sequence[Scalar]) -> Scalar:
    """Sum of the terms."""
    result: Scalar = 0.0
    for term in terms:
        result = add(result, term)
    return result


def dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    """Inner product."""
    return total([mul(x, y) for x, y in zip(a, b, strict=True)])


def plus(a: Vector, b: Vector) -> Vector:
    """Vector sum a + b."""
    return (add(a[0], b[0]), add(a[1], b[1]), add(a[2], b[2]))


def minus(a: Vector, b: Vector) -> Vector:
    """Vector difference a - b."""
    return (sub(a[0], b[0]), sub(a[1], b[1]), sub(a[2], b[2]))


def scale(s: Scalar, a: Vector) -> Vector:
    """Vector s a."""
    return (mul(s, a[0]), mul(s, a[1]), mul(s, a[2]))


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product a x b."""
    return (
        sub(mul(a[1], b[2]), mul(a[2], b[1])),
        sub(mul(a[2], b[0]), mul(a[0], b[2])),
        sub(mul(a[0], b[1]), mul(a[1], b[0])),
    )


def apply(rows: Matrix, a: Vector) -> Vector:
    """Matrix times vector."""
    return (dot(rows[0], a), dot(rows[1], a), dot(rows[2], a))


def apply_transposed(rows: Matrix, a: Vector) -> Vector:
    """Transposed matrix times vector."""
    columns = tuple(zip(*rows, strict=True))
    return (dot(columns[0], a), dot(columns[1], a), dot(columns[2], a))


def sin(a: Scalar) -> Scalar:
    """Sine of any kind of scalar."""
    casadi = _symbolic(a)
    return casadi.sin(a) if casadi else np.sin(a)


def cos(a: Scalar) -> Scalar:
    """Cosine of any kind of scalar."""
    casadi = _symbolic(a)
    return casadi.cos(a) if casadi else np.cos(a)


def tanh(a: Scalar) -> Scalar:
    """Hyperbolic tangent of any kind of scalar."""
    casadi = _symbolic(a)
    return casadi.tanh(a) if casadi else np.tanh(a)


def exp(a: Scalar) -> Scalar:
    """Exponential of any kind of scalar."""
    casadi = _symbolic(a)
    return casadi.exp(a) if casadi else np.exp(a)


def magnitude(a: Scalar) -> Scalar:
    """Absolute value of any kind of scalar."""
    casadi = _symbolic(a)
    return casadi.fabs(a) if casadi else np.abs(a)


def asinh(a: Scalar) -> Scalar:
    """Inverse hyperbolic sine of any kind of scalar."""
    casadi = _symbolic(a)
    return casadi.asinh(a) if casadi else np.arcsinh(a)


def within(a: Scalar, lower: float, upper: float) -> Scalar:
    """Any kind of scalar, brought to the nearer bound where it is outside."""
    casadi = _symbolic(a)
    if casadi:
        return casadi.fmin(casadi.fmax(a, lower), upper)
    return np.clip(a, lower, upper)


def at_least(a: Scalar, bound: float) -> Scalar:
    """1 where any kind of scalar is no less than a bound, else 0."""
    casadi = _symbolic(a)
    if casadi:
        return casadi.if_else(a >= bound, 1.0, 0.0)
    return np.asarray(a >= bound, dtype=float)[()]


def sign(a: Scalar) -> Scalar:
    """Sign of any kind of scalar, with sign(0) = 0."""
    casadi = _symbolic(a)
    return casadi.sign(a) if casadi else np.sign(a)


def mean_sign(v: Float[ndarray, " samples"], width: float) -> Float[ndarray, " samples"]:
    """Mean of tanh(v / width) over the step of each sample, v linear between samples.

    A sign that is sampled turns at a sample; its mean turns where the velocity does, and moves
    smoothly with it.

    Args:
        v: At evenly spaced instants, two or more.
        width: 0 for the exact sign.
    """
    middle = (v[1:] + v[:-1]) / 2
    edges = np.concatenate([v[:1], middle, v[-1:]])
    # The integral of the sign: |v|, rounded off at zero.
    rounded = width * np.log1p(np.exp(-2 * np.abs(edges) / width)) if width > 0 else 0.0
    rise, run = np.diff(np.abs(edges) + rounded), np.diff(edges)
    # Where the velocity stands still a quotient of differences is rounding.
    moves = np.abs(run) > STILL * np.maximum(np.abs(v), width)
    still = np.tanh(v[~moves] / width) if width > 0 else np.sign(v[~moves])
    mean = np.divide(rise, run, out=np.empty_like(v), where=moves)
    mean[~moves] = still
    return mean


def power(a: Scalar, exponent: float) -> Scalar:
    """Any kind of scalar raised to a constant."""
    casadi = _symbolic(a)
    return casadi.power(a, exponent) if casadi else np.power(a, exponent)
