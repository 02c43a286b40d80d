"""A lag smooths what an encoder errs as well, and seems to explain by that.

Errors in the regressor are the model's own: a model that passes them through a filter leaves
less of them, whatever the arm does. So much of a lag's gain says nothing of the arm.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.data.encoder_steps import encoder_torque
from oed.diagnosis.fit.rows import Rows
from oed.diagnosis.search.workbench import lags_of
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.torque_model import TorqueModel


def calmed(shop: Workshop, trial: Trial, rows: Rows) -> Float[ndarray, " joints"]:
    """(n,) white squares by which a lag quietens the errors of encoders; 0 of all others."""
    lags = lags_of([trial])
    if not lags:
        return np.zeros(shop.baseline.model.robot.n)
    model = shop.baseline.model
    return _heard(shop, model, rows) - _heard(shop, model.with_measurement(*lags), rows)


def _heard(shop: Workshop, model: TorqueModel, rows: Rows) -> Float[ndarray, " joints"]:
    noise = [p.position_noise for p in rows.prepared]
    errors = encoder_torque(model, shop.before.fit.full_parameters(), rows.prepared, noise)
    joints = range(rows.weights.shape[1])
    return np.array([np.sum(rows.whiten([e[:, [j]] for e in errors], j) ** 2) for j in joints])
