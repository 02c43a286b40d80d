"""The paper's other form: the same parameters from work over windows instead of torque."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.energy_model import EnergyModel
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.paper_signals import Processing, processed_signals
from oed.experiment.simulation import Log
from oed.robot.builtin import imi_scara
from studies.paper_experiment.laboratory import PERIOD

# Xi of the paper by the names that its columns carry in the torque model.
XI_NAMES = ("Izz_1", "mx_2", "my_2", "Izz_2", "Fc_1", "Fv_1", "Fc_2", "Fv_2")
WAYS: tuple[Processing, Processing] = ("online", "zero_phase")


def energy_estimates(
    log: Log, way: Processing, samples: int, sets: Sequence[range]
) -> Float[ndarray, "E 8"]:
    """Estimate xi from each of some sets of a log's runs, one row for each of `samples` windows."""
    model, base = _model()
    order = [base.names.index(name) for name in XI_NAMES]
    form = EnergyModel(model, max(1, log.samples // samples))
    proper = slice(log.lead, log.lead + log.samples)
    signals = [x[proper] for x in processed_signals(log, PERIOD, way)]
    t = np.arange(log.samples) * PERIOD
    found = []
    for runs in sets:
        rows, works = [], []
        for run in runs:
            q, dq, ddq, tau = (np.ascontiguousarray(x[:, :, run]) for x in signals)
            motion = Motion(t, q, dq, ddq)
            rows.append(base.reduce(form.regressor(motion))[:, order])
            works.append(form.target(motion, tau))
        found.append(np.linalg.lstsq(np.concatenate(rows), np.concatenate(works), rcond=None)[0])
    return np.array(found)


@cache
def _model() -> tuple[TorqueModel, BaseParameters]:
    model = TorqueModel.standard(imi_scara())
    return model, base_parameters(model)
