"""A lag smooths what an encoder's steps err as well, and seems to explain by that.

Errors in the regressor are the model's own: a model that passes them through a filter leaves
less of them, whatever the arm does. So much of a lag's gain says nothing of the arm.
"""

from __future__ import annotations

import numpy as np

from oed.diagnosis.data.encoder_steps import rounding_torque
from oed.diagnosis.search.workbench import lags_of
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.torque_model import TorqueModel


def calmed(shop: Workshop, trial: Trial) -> float:
    """White squares by which a lag quietens the repeated rounding of encoders; 0 of all others."""
    lags = lags_of([trial])
    if not lags or not any(p.steps.any() for p in shop.estimation):
        return 0.0
    model = shop.baseline.model
    return _heard(shop, model) - _heard(shop, model.with_measurement(*lags))


def _heard(shop: Workshop, model: TorqueModel) -> float:
    rows = shop.mean.rows
    errors = rounding_torque(model, shop.before.fit.full_parameters(), rows.prepared)
    joints = range(rows.weights.shape[1])
    return float(sum(np.sum(rows.whiten([e[:, [j]] for e in errors], j) ** 2) for j in joints))
