"""Effects that act only where no log tells which way a joint moves, if at all.

A joint that sticks is held by friction anywhere between its two heights, and the controller, not the
velocity, decides where. What a model of the velocity explains there is how the joint was stopped.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.rows.model_columns import effect_columns
from oed.experiment.preparation.direction import uncertain_direction

NEARLY_ALL = 0.9  # share of an effect's squares; friction that falls with speed has up to 0.7 there


def acts_at_standstill(
    shop: Workshop, trial: Trial, coefficients: Float[ndarray, " columns"]
) -> str | None:
    """Why nothing tells what an addition does from how its joint sticks; None if something does.

    Args:
        shop: The laid-out data.
        trial: The addition; one of the whole arm acts everywhere.
        coefficients: Of its columns.
    """
    joint = trial.joint
    if joint is None:
        return None
    inside = whole = 0.0
    for prepared in shop.estimation:
        columns = effect_columns(trial.effect, prepared.motion, 0.0)
        squares = (columns[joint] @ coefficients) ** 2
        inside += float(np.sum(squares[uncertain_direction(prepared, joint)]))
        whole += float(np.sum(squares))
    if inside <= NEARLY_ALL * whole:
        return None
    return f"{inside / whole:.0%} of it acts where the joint sticks"
