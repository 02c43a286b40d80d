"""The parameters of a named effect, as they may be told: values, deviations and units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.turning import GRAVITY, total_tilt
from oed.diagnosis.evidence.profile import UNIFORM
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.entries.motor import ONE_WAY
from oed.dynamics.effects.gravity import tilt_directions
from oed.dynamics.effects.motor import CrossCoupling
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.effects.thermal import since

STEP = 1e-4  # [rad] of a difference
ANYWHERE = 0.99  # of the deviation of a shape of which nothing is known, from which on it is that
RESOLVED = 1e-12  # of the largest variance, below which one is a rounding error
# [rad], of an angle that may be any: a tilt about an axis along which no joint feels gravity.
UNSEEN_TILT = np.pi / np.sqrt(3)


@dataclass(frozen=True)
class Estimated:
    """A parameter of an effect.

    Attributes:
        name: Symbol in words.
        value: In `unit`.
        std: Standard deviation.
        unit: SI unit.
    """

    name: str
    value: float
    std: float
    unit: str


def estimates(
    shop: Workshop,
    trial: Trial,
    coefficients: Float[ndarray, " columns"],
    covariance: Float[ndarray, "parameters parameters"],
) -> tuple[Estimated, ...]:
    """Coefficients of an effect, unless they are fixed, then its shapes.

    Args:
        shop: The laid-out data.
        trial: The effect.
        coefficients: Of its columns.
        covariance: Of the coefficients and the shapes on their axes.
    """
    count = 0 if trial.fixed else len(coefficients)
    if trial.name == GRAVITY:
        covariance = _with_unfelt(trial, covariance)
    values, covariance = from_declared(shop, trial, coefficients, covariance)
    deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    sizes = [
        Estimated(p.name, float(value), float(std), p.unit)
        for p, value, std in zip(trial.effect.parameters[:count], values, deviations, strict=False)
    ]
    return (*sizes, *_shapes(shop, trial, deviations[count:]))


def _with_unfelt(
    trial: Trial, covariance: Float[ndarray, "parameters parameters"]
) -> Float[ndarray, "parameters parameters"]:
    """The covariance of a tilt, its angles free where its columns show nothing of them."""
    variances = np.diag(covariance)
    angles = np.array([p.unit == "rad" for p in trial.effect.parameters])
    unfelt = np.flatnonzero(angles & (variances[: len(angles)] <= RESOLVED * variances.max()))
    free = covariance.copy()
    free[unfelt, unfelt] = UNSEEN_TILT**2
    return free


def _shapes(shop: Workshop, trial: Trial, on_axes: Float[ndarray, " shapes"]) -> list[Estimated]:
    """Shapes with their deviations, given on their axes."""
    shapes = CATALOGUE[trial.name].shapes_for(shop.context, trial.target)
    found = []
    for shape, value, on_axis in zip(shapes, trial.values, on_axes, strict=False):
        lead = 0.0
        is_told = shape.is_estimated and not shape.is_plain(value)
        std = float(on_axis) * shape.slope_at(value) if is_told else 0.0
        if isinstance(trial.effect, PayloadChange) and shape.name == "moment":
            std = max(std, _unseen_stretch(shop, trial.effect) / np.sqrt(12))
            lead = shop.full.rows.prepared[0].band.lead
        if isinstance(trial.effect, CrossCoupling) and shape.name == "ratio":
            std = max(std, ONE_WAY / np.sqrt(3))  # all that are so small are one
        # A shape can be no less certain than anywhere in its range: from its end, that is further off.
        width, middle = shape.upper - shape.lower, (shape.upper + shape.lower) / 2
        anywhere = np.hypot(width / np.sqrt(12), value - middle)
        if is_told and on_axis > ANYWHERE * UNIFORM:
            std = anywhere
        found.append(Estimated(shape.name, value + lead, float(min(std, anywhere)), shape.unit))
    return found


def _unseen_stretch(shop: Workshop, change: PayloadChange) -> float:
    """Time between the rows before and after a moment [s]: it may lie anywhere in between."""
    own = [p.band.instants(since(p.motion.t, change.start)) for p in shop.estimation]
    t = np.sort(np.concatenate(own)) - change.moment
    before, after = t[t <= 0], t[t > 0]
    return float(after[0] - before[-1]) if len(before) and len(after) else 0.0


def from_declared(
    shop: Workshop,
    trial: Trial,
    coefficients: Float[ndarray, " columns"],
    covariance: Float[ndarray, "parameters parameters"],
) -> tuple[Float[ndarray, " columns"], Float[ndarray, "parameters parameters"]]:
    """Coefficients and their covariance, a tilt's counted from the declared gravity.

    Turned tables have directions of their own, in which a tilt is estimated.

    Args:
        shop: The laid-out data.
        trial: The effect.
        coefficients: Of its columns.
        covariance: Of these, and of what comes after them.
    """
    if trial.name != GRAVITY or not shop.is_turned:
        return coefficients, covariance
    count = len(tilt_directions(shop.baseline.model.robot.gravity)[0])
    here = coefficients[:count]
    steps = STEP * np.eye(count)
    slope = np.eye(len(covariance))
    slope[:count, :count] = np.stack(
        [(total_tilt(shop, here + h) - total_tilt(shop, here - h)) / (2 * STEP) for h in steps],
        axis=1,
    )
    values = np.concatenate([total_tilt(shop, here), coefficients[count:]])
    return values, slope @ covariance @ slope.T
