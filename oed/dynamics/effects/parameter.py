"""Linear parameters of a torque model, and what physics asks of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Parameter:
    """A linear parameter of a torque model.

    Attributes:
        name: Symbol and joint number from 1, such as "Fv_2".
        unit: SI unit.
        joint: Index of the joint it belongs to, None for the whole arm.
    """

    name: str
    unit: str
    joint: int | None


@dataclass(frozen=True)
class Demand:
    """What physics asks of an effect's parameters: weights @ parameters >= bound.

    Attributes:
        weights: One a parameter.
        bound: In the unit of their sum.
        words: What it says.
    """

    weights: tuple[float, ...]
    bound: float
    words: str


def not_negative(parameters: Sequence[Parameter]) -> tuple[Demand, ...]:
    """That none of some parameters, all of an effect, is negative."""
    rows = np.eye(len(parameters)).tolist()
    return tuple(
        Demand(tuple(row), 0.0, f"{p.name} >= 0") for row, p in zip(rows, parameters, strict=True)
    )
