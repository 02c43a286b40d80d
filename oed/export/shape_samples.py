"""Shapes that the data do not tell apart: Stribeck speeds, exponents, shares of a load.

A model's covariance is one of its linear parameters. Shapes have deviations of their own, and are
drawn one by one, beside the others: normal on the scale on which each is estimated (a speed on that
of its logarithm), cut off at the ends of what is plausible; evenly between these where the data leave
it open. Numbers that were chosen, such as of terms, stay.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import truncnorm

from oed.dynamics.effects import Effect
from oed.dynamics.effects.catalogue import CATALOGUE, Shape
from oed.dynamics.torque_model import TorqueModel
from oed.export.model import ShapeEstimate


@dataclass(frozen=True)
class DrawnShapes:
    """Models with other shapes, and which these are.

    Attributes:
        models: The effects whose shapes were drawn are new objects, all others the model's own.
        names: Of the shapes that were drawn, in words.
        left: Of those in doubt that were not, as no field of their effect goes by their name.
    """

    models: tuple[TorqueModel, ...]
    names: tuple[str, ...]
    left: tuple[str, ...]


def draw_shapes(
    model: TorqueModel,
    shapes: Sequence[tuple[ShapeEstimate, ...]],
    count: int,
    rng: np.random.Generator,
) -> DrawnShapes:
    """Models whose shapes the data do not tell from those of a model.

    Args:
        model: Whose effects are in doubt.
        shapes: Of each effect, as they were estimated.
        count: How many models.
        rng: Of the draws.
    """
    effects = [list(model.effects) for _ in range(count)]
    names, left = [], []
    for k, (effect, own) in enumerate(zip(model.effects, shapes, strict=False)):
        for estimate, shape in _in_doubt(effect, own):
            name = _in_words(effect, estimate)
            if getattr(effect, estimate.name, None) != estimate.value:
                left.append(name)
                continue
            names.append(name)
            for drawn, value in zip(effects, _draw(estimate, shape, count, rng), strict=True):
                drawn[k] = dataclasses.replace(drawn[k], **{estimate.name: float(value)})  # pyright: ignore[reportArgumentType]  # an effect is a dataclass
    models = tuple(dataclasses.replace(model, effects=tuple(own)) for own in effects)
    return DrawnShapes(models, tuple(names), tuple(left))


def _in_doubt(
    effect: Effect, estimates: Sequence[ShapeEstimate]
) -> Iterator[tuple[ShapeEstimate, Shape]]:
    """Shapes of an effect that are estimated, and not exactly, with their scales."""
    entry = CATALOGUE.get(effect.name)
    scales = {} if entry is None else {shape.name: shape for shape in entry.shapes}
    for estimate in estimates:
        shape = scales.get(estimate.name)
        if shape is None or not shape.is_estimated or estimate.std == 0:
            continue
        if not (shape.is_plain(estimate.value) or shape.is_idle(estimate.value)):
            yield estimate, shape


def _draw(
    estimate: ShapeEstimate, shape: Shape, count: int, rng: np.random.Generator
) -> Float[ndarray, " count"]:
    share = rng.uniform(size=count)
    if estimate.std is not None:
        centre = shape.place_of(estimate.value)
        std = estimate.std / shape.slope_at(estimate.value)
        ends = (np.array([min(0.0, centre), max(1.0, centre)]) - centre) / std
        share = centre + std * truncnorm.ppf(share, *ends)
    return np.array([shape.outside(place) for place in share])


def _in_words(effect: Effect, estimate: ShapeEstimate) -> str:
    joint = getattr(effect, "joint", None)
    where = "" if joint is None else f" of joint {joint + 1}"
    return f"{estimate.name} of {effect.name}{where}"
