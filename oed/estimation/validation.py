"""How well given parameters predict the torque of data they were not estimated from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

SMALLEST = 1e-300


@dataclass(frozen=True)
class Validation:
    """Residual of a parameter set on some data.

    Attributes:
        residual: (N, n) measured less predicted torque [N m].
        rms: (n,) root mean square residual of each joint, rows counted by their certainty [N m].
        relative_rms: (n,) rms residual / rms torque, as in Calafiore 2001, section 5; NaN for
            a joint without torque.
        overall_rms: Root mean square residual over all joints [N m].
        overall_relative_rms: The same / rms torque over all joints; NaN without torque.
        r_squared: (n,) share of each joint's torque variance that is predicted; it is
            negative if the mean torque predicts better, NaN if the torque is constant.
    """

    residual: Float[ndarray, "samples joints"]
    rms: Float[ndarray, " joints"]
    relative_rms: Float[ndarray, " joints"]
    overall_rms: float
    overall_relative_rms: float
    r_squared: Float[ndarray, " joints"]

    @property
    def samples(self) -> int:
        """N."""
        return len(self.residual)


def validate(
    predicted: Float[ndarray, "samples joints"],
    measured: Float[ndarray, "samples joints"],
    certainty: Float[ndarray, "samples joints"] | None = None,
) -> Validation:
    """Compare predicted with measured torque.

    Args:
        predicted: (N, n) torque of the model [N m].
        measured: (N, n) torque [N m].
        certainty: (N, n) by which squares count: where the direction of motion is uncertain, dry
            friction makes a row uncertain for every model. All alike if None.

    Raises:
        ValueError: If shapes differ, there is no sample, or an entry is not finite.
    """
    if predicted.shape != measured.shape or not len(measured):
        raise ValueError(f"predicted {predicted.shape} against measured {measured.shape} torques")
    residual = measured - predicted
    if not np.isfinite(residual).all():
        raise ValueError("the predicted or measured torque has entries that are not finite")
    weights = np.ones_like(measured) if certainty is None else certainty

    def mean(values: Float[ndarray, "samples joints"]) -> Float[ndarray, " joints"]:
        return np.sum(values * weights, axis=0) / np.maximum(weights.sum(axis=0), SMALLEST)

    squares, power = mean(residual**2), mean(measured**2)
    deviation = mean((measured - mean(measured)) ** 2)
    return Validation(
        residual=residual,
        rms=np.sqrt(squares),
        relative_rms=np.sqrt(_ratio(squares, power)),
        overall_rms=float(np.sqrt(squares.mean())),
        overall_relative_rms=float(np.sqrt(_ratio(squares.sum(), power.sum()))),
        r_squared=1 - _ratio(squares, deviation),
    )


def _ratio(
    part: Float[ndarray, "*n"] | float, whole: Float[ndarray, "*n"] | float
) -> Float[ndarray, "*n"]:
    part, whole = np.asarray(part, dtype=float), np.asarray(whole, dtype=float)
    return np.divide(part, whole, out=np.full_like(whole, np.nan), where=whole > 0)
