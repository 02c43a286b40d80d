"""A CasADi expression evaluated on many points at once, or on many boxes in interval arithmetic.

Intervals are rounded to nearest, not outward: `ROUNDING` widens what is concluded from them by
far more than the rounding of the few thousand operations of an expression.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

ROUNDING = 1e-9  # relative to the largest value found
Value = ndarray | np.floating  # one a point or box, or a constant
Interval = tuple[Value, Value]


@dataclass(frozen=True)
class Tape:
    """The instructions of a function of one vector to one vector.

    Attributes:
        function: The CasADi function of scalar operations.
    """

    function: casadi.Function

    def values(self, points: Float[ndarray, "points inputs"]) -> Float[ndarray, "points outputs"]:
        """Outputs at every point."""
        shape = (len(points), self.function.numel_out(0))
        results = np.zeros(shape)

        def store(output: int, value: Value) -> None:
            results[:, output] = value

        self._walk(lambda i: points[:, i], np.float64, POINT, store)
        return results

    def intervals(
        self, lower: Float[ndarray, "boxes inputs"], upper: Float[ndarray, "boxes inputs"]
    ) -> tuple[Float[ndarray, "boxes outputs"], Float[ndarray, "boxes outputs"]]:
        """Bounds of every output on every box."""
        shape = (len(lower), self.function.numel_out(0))
        low, high = np.zeros(shape), np.zeros(shape)

        def store(output: int, value: Interval) -> None:
            low[:, output], high[:, output] = value

        self._walk(
            lambda i: (lower[:, i], upper[:, i]), lambda c: (np.float64(c),) * 2, INTERVAL, store
        )
        return low, high

    def _walk(self, read: Callable, constant: Callable, rules: dict, store: Callable) -> None:
        """Run the instructions with one set of rules."""
        work: dict[int, object] = {}
        for operation, inputs, outputs, number in self._instructions:
            if operation == casadi.OP_CONST:
                work[outputs[0]] = constant(number)
            elif operation == casadi.OP_INPUT:
                work[outputs[0]] = read(inputs[1])
            elif operation == casadi.OP_OUTPUT:
                store(outputs[1], work[inputs[0]])
            else:
                work[outputs[0]] = rules[operation](*(work[i] for i in inputs))

    @cached_property
    def _instructions(self) -> list[tuple[int, list[int], list[int], float]]:
        function = self.function
        return [
            (
                function.instruction_id(k),
                function.instruction_input(k),
                function.instruction_output(k),
                function.instruction_constant(k)
                if function.instruction_id(k) == casadi.OP_CONST
                else 0.0,
            )
            for k in range(function.n_instructions())
        ]


def _add(a: Interval, b: Interval) -> Interval:
    return a[0] + b[0], a[1] + b[1]


def _subtract(a: Interval, b: Interval) -> Interval:
    return a[0] - b[1], a[1] - b[0]


def _multiply(a: Interval, b: Interval) -> Interval:
    if a[0] is a[1]:
        a, b = b, a
    if b[0] is b[1]:  # a constant or a fixed input
        first, second = a[0] * b[0], a[1] * b[0]
        return np.minimum(first, second), np.maximum(first, second)
    products = (a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1])
    low = np.minimum(np.minimum(products[0], products[1]), np.minimum(products[2], products[3]))
    high = np.maximum(np.maximum(products[0], products[1]), np.maximum(products[2], products[3]))
    return low, high


def _square(a: Interval) -> Interval:
    first, second = a[0] ** 2, a[1] ** 2
    straddles = (a[0] < 0) & (a[1] > 0)
    return np.where(straddles, 0.0, np.minimum(first, second)), np.maximum(first, second)


def _sine(a: Interval) -> Interval:
    """Contains a crest where the interval contains pi/2 + 2 pi k, a trough half a turn later."""
    first, second = np.sin(a[0]), np.sin(a[1])
    turn = 2 * np.pi
    has_crest = np.floor((a[1] - np.pi / 2) / turn) >= np.ceil((a[0] - np.pi / 2) / turn)
    has_trough = np.floor((a[1] + np.pi / 2) / turn) >= np.ceil((a[0] + np.pi / 2) / turn)
    low = np.where(has_trough, -1.0, np.minimum(first, second))
    return low, np.where(has_crest, 1.0, np.maximum(first, second))


def _cosine(a: Interval) -> Interval:
    return _sine((a[0] + np.pi / 2, a[1] + np.pi / 2))


def _sign(a: Interval) -> Interval:
    """At zero the limit from the inside: boxes end at zero velocity, they do not cross it."""
    return np.where(a[0] >= 0, 1.0, -1.0), np.where(a[1] <= 0, -1.0, 1.0)


def _increasing(function: Callable) -> Callable[[Interval], Interval]:
    return lambda a: (function(a[0]), function(a[1]))


def _magnitude(a: Interval) -> Interval:
    first, second = np.abs(a[0]), np.abs(a[1])
    straddles = (a[0] < 0) & (a[1] > 0)
    return np.where(straddles, 0.0, np.minimum(first, second)), np.maximum(first, second)


INTERVAL: dict[int, Callable] = {
    casadi.OP_ASSIGN: lambda a: a,
    casadi.OP_ADD: _add,
    casadi.OP_SUB: _subtract,
    casadi.OP_NEG: lambda a: (-a[1], -a[0]),
    casadi.OP_MUL: _multiply,
    casadi.OP_SQ: _square,
    casadi.OP_TWICE: lambda a: (2 * a[0], 2 * a[1]),
    casadi.OP_SIN: _sine,
    casadi.OP_COS: _cosine,
    casadi.OP_TANH: _increasing(np.tanh),
    casadi.OP_EXP: _increasing(np.exp),
    casadi.OP_SIGN: _sign,
    casadi.OP_FABS: _magnitude,
}
POINT: dict[int, Callable] = {
    casadi.OP_ASSIGN: lambda a: a,
    casadi.OP_ADD: np.add,
    casadi.OP_SUB: np.subtract,
    casadi.OP_NEG: np.negative,
    casadi.OP_MUL: np.multiply,
    casadi.OP_SQ: np.square,
    casadi.OP_TWICE: lambda a: 2 * a,
    casadi.OP_SIN: np.sin,
    casadi.OP_COS: np.cos,
    casadi.OP_TANH: np.tanh,
    casadi.OP_EXP: np.exp,
    casadi.OP_SIGN: np.sign,
    casadi.OP_FABS: np.abs,
}
