"""A proven maximum of a smooth function over boxes, by branch and bound."""

from __future__ import annotations

from dataclasses import dataclass

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.bound.deadline import NEVER, Deadline
from oed.design.bound.tape import ROUNDING, Tape

CHUNK = 4096  # boxes at a time: intermediate results stay in the processor's cache


@dataclass(frozen=True)
class Boxes:
    """Boxes of coordinates, each with parameters that stay fixed on it.

    Attributes:
        middle: (N, d) centres.
        half: (N, d) half widths.
        fixed: (N, k) fixed parameters.
    """

    middle: Float[ndarray, "boxes coordinates"]
    half: Float[ndarray, "boxes coordinates"]
    fixed: Float[ndarray, "boxes parameters"]

    def __len__(self) -> int:
        return len(self.middle)

    def __getitem__(self, which: slice | ndarray) -> Boxes:
        return Boxes(self.middle[which], self.half[which], self.fixed[which])

    def split(self, axis: ndarray) -> Boxes:
        """Every box cut in two along its own axis."""
        rows = np.arange(len(self))
        half = self.half.copy()
        half[rows, axis] /= 2
        shift = np.zeros_like(half)
        shift[rows, axis] = half[rows, axis]
        return Boxes(
            np.concatenate([self.middle - shift, self.middle + shift]),
            np.concatenate([half, half]),
            np.concatenate([self.fixed, self.fixed]),
        )


@dataclass(frozen=True)
class ProvenMaximum:
    """What branch and bound found.

    Attributes:
        upper: The function exceeds this nowhere.
        attained: Its largest value found.
        points: Coordinates of the largest values found, best first.
        fixed: Their fixed parameters.
        boxes: Number of boxes that were bounded.
    """

    upper: float
    attained: float
    points: Float[ndarray, "points coordinates"]
    fixed: Float[ndarray, "points parameters"]
    boxes: int


@dataclass(frozen=True)
class SmoothFunction:
    """A function of coordinates x and fixed parameters, with derivatives by x.

    Attributes:
        slopes: (x, fixed) -> value and gradient.
        curvature: (x, fixed) -> upper triangle of the Hessian, row by row.
    """

    slopes: Tape
    curvature: Tape

    @classmethod
    def of(cls, value: casadi.SX, x: casadi.SX, fixed: casadi.SX) -> SmoothFunction:
        """From an expression."""
        gradient = casadi.gradient(value, x)
        hessian = casadi.jacobian(gradient, x)
        upper = [hessian[i, j] for i in range(x.numel()) for j in range(i, x.numel())]
        inputs = casadi.vertcat(x, fixed)

        def tape(name: str, *outputs: casadi.SX) -> Tape:
            result = casadi.cse(casadi.densify(casadi.vertcat(*outputs)))
            return Tape(casadi.Function(name, [inputs], [result]))

        return cls(tape("slopes", value, gradient), tape("curvature", *upper))

    def value(self, boxes: Boxes) -> Float[ndarray, " boxes"]:
        """At the centres."""
        return self.slopes.values(np.concatenate([boxes.middle, boxes.fixed], axis=1))[:, 0]

    def bounds(self, boxes: Boxes) -> tuple[ndarray, ndarray, ndarray]:
        """Value at the centres, upper bound on the boxes, and what each coordinate adds to it.

        By Taylor's theorem f(m + d) <= f(m) + |f'(m)| |d| + |d|' max H |d| / 2 with the Hessian
        bounded over the box; on the diagonal only what bends upward counts.
        """
        middle = np.concatenate([boxes.middle, boxes.fixed], axis=1)
        half = np.concatenate([boxes.half, np.zeros_like(boxes.fixed)], axis=1)
        slopes = self.slopes.values(middle)
        low, high = self.curvature.intervals(middle - half, middle + half)
        first, second = np.triu_indices(boxes.half.shape[1])
        on_diagonal = first == second
        bend = np.where(on_diagonal, np.maximum(high, 0.0) / 2, np.maximum(-low, high))
        by_pair = bend * boxes.half[:, first] * boxes.half[:, second]
        by_axis = np.abs(slopes[:, 1:]) * boxes.half
        for pair, (i, j) in enumerate(zip(first, second, strict=True)):
            by_axis[:, i] += by_pair[:, pair] / 2
            by_axis[:, j] += by_pair[:, pair] / 2
        return slopes[:, 0], slopes[:, 0] + by_axis.sum(axis=1), by_axis


def prove_maximum(
    function: SmoothFunction,
    boxes: Boxes,
    *,
    tolerance: float = 0.01,
    at_least: float = -np.inf,
    most_boxes: int = 1_000_000,
    points: int = 500,
    deadline: Deadline = NEVER,
) -> ProvenMaximum:
    """A proven upper bound on the maximum over all boxes.

    Args:
        function: Smooth inside every box.
        boxes: To begin with.
        tolerance: Allowed excess of the bound over the largest value, relative.
        at_least: A value below which the bound need not go.
        most_boxes: Bounded in all; when they are used up the bound is what is left open.
        points: Number of good points to return.
        deadline: When to give up.

    Raises:
        OutOfTime: At the deadline.
    """
    attained, proven, done = -np.inf, -np.inf, 0
    found: list[tuple[ndarray, ndarray, ndarray]] = []
    while len(boxes):
        parts = []
        for i in range(0, len(boxes), CHUNK):
            deadline.check()
            parts.append(function.bounds(boxes[i : i + CHUNK]))
        value, upper, by_axis = (np.concatenate(part) for part in zip(*parts, strict=True))
        done += len(boxes)
        attained = max(attained, float(value.max()))
        best = np.argsort(-value)[:points]
        found.append((value[best], boxes.middle[best], boxes.fixed[best]))
        goal = max(attained, at_least)
        goal += tolerance * abs(goal)
        is_open = upper > goal
        proven = max(proven, float(upper[~is_open].max(initial=-np.inf)))
        if done + 2 * is_open.sum() > most_boxes:
            proven = max(proven, float(upper[is_open].max(initial=-np.inf)))
            break
        boxes = boxes[is_open].split(by_axis[is_open].argmax(axis=1))
    values, middles, fixed = (np.concatenate(part) for part in zip(*found, strict=True))
    order = np.argsort(-values, kind="stable")[:points]
    upper = proven + ROUNDING * max(abs(proven), abs(attained))
    return ProvenMaximum(upper, attained, middles[order], fixed[order], done)
