"""What late torques explain beyond what they make of noise.

A delay is chosen where it explains most of what the arm does, not of what encoders err and shakes
move. Beside another late torque nothing is told apart: the noise has been through that already.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.fit.motion_noise import calmed
from oed.diagnosis.tables.workbench import lags_of
from oed.diagnosis.terms.scores import Score, Worth
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.rows.weighted_rows import Rows


def calmed_beside(others: Sequence[Trial], trial: Trial, rows: Rows) -> Float[ndarray, " joints"]:
    """(n,) white squares of noise alone that an addition takes away beside others."""
    if lags_of(others):
        return np.zeros(rows.weights.shape[1])
    return calmed(trial.effect, rows)


def worth_beside(others: Sequence[Trial], rows: Rows) -> Worth:
    """What candidates gain beside others but for that."""

    def worth(found: Score) -> float:
        return found.gain - float(calmed_beside(others, found.trial, rows).sum())

    return worth
