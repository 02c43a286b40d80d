"""Shapes on axes from 0 at their lower to 1 at their upper bound, logarithmic where they are."""

import numpy as np

from oed.dynamics.effects.catalogue import Shape


def to_axis(value: float, shape: Shape) -> float:
    """Where a value lies between its bounds."""
    if shape.upper <= shape.lower:
        return 0.0
    if shape.scale == "log":
        return float(np.log(value / shape.lower) / np.log(shape.upper / shape.lower))
    return float((value - shape.lower) / (shape.upper - shape.lower))


def from_axis(position: float, shape: Shape) -> float:
    """The value there; positions outside are brought to the bound."""
    inside = float(np.clip(position, 0.0, 1.0))
    if shape.scale == "log":
        return float(shape.lower * (shape.upper / shape.lower) ** inside)
    value = shape.lower + inside * (shape.upper - shape.lower)
    return float(value) if shape.is_estimated else float(round(value))


def axis_slope(value: float, shape: Shape) -> float:
    """Change of the value for a unit step along its axis."""
    if shape.scale == "log":
        return float(value * np.log(shape.upper / shape.lower))
    return float(shape.upper - shape.lower)
