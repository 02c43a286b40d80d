"""How the torque of an addition changes with its shapes."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.terms.trials import Trial, catalogue_trial, dense, moved
from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.dynamics.effects.catalogue import CATALOGUE, Context

SHAPE_STEP = 0.01  # of a shape's range, for derivatives


def secants(
    trial: Trial,
    coefficients: Float[ndarray, " columns"],
    rows: Rows,
    context: Context,
    steps: Float[ndarray, " shapes"],
) -> Float[ndarray, "joints rows shapes"]:
    """Change of an addition's white torque along each shape's axis, over a step both ways.

    One way alone where a step the other way leads to a formula of other columns, zero between two.

    Args:
        trial: The addition.
        coefficients: Of its columns.
        rows: White rows.
        context: Rebuilds the addition.
        steps: On each axis; cut at its ends.
    """
    joints = rows.weights.shape[1]
    if not trial.values:
        return np.zeros((joints, rows.count, 0))
    entry = CATALOGUE[trial.name]
    shapes = entry.shapes_for(context, trial.target)
    axes = np.array([s.place_of(v) for v, s in zip(trial.values, shapes, strict=True)])

    def torque(place: int, axis: float) -> tuple[float, Float[ndarray, "joints rows"]]:
        values = list(trial.values)
        values[place] = shapes[place].at(axis)
        there = catalogue_trial(entry, context, trial.target, tuple(values), rows)
        if len(there.effect.parameters) != len(coefficients):
            axis, there = float(axes[place]), moved(trial, rows, context)
        return axis, dense(there, joints, rows.count) @ coefficients

    columns = []
    for k, (axis, step) in enumerate(zip(axes, steps, strict=True)):
        lower, upper = max(axis - step, 0.0), min(axis + step, 1.0)
        if upper <= lower or shapes[k].scale == "formula":
            columns.append(np.zeros((joints, rows.count)))
            continue
        (above, more), (below, less) = torque(k, upper), torque(k, lower)
        columns.append((more - less) / (above - below) if above > below else 0.0 * more)
    return np.stack(columns, axis=2)


def shape_derivatives(
    trial: Trial, coefficients: Float[ndarray, " columns"], rows: Rows, context: Context
) -> Float[ndarray, "joints rows shapes"]:
    """Secants over a small step."""
    return secants(trial, coefficients, rows, context, np.full(len(trial.values), SHAPE_STEP))
