"""Whether what passes for a coupled motor has anything of a motor."""

from __future__ import annotations

import numpy as np

from oed.diagnosis.evidence.uncertainty import at_given_shapes
from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.effects.entries.motor import MOTOR_COUPLING

OWN = ("Ia", "Fc")  # a rotor's inertia, and the dry friction of its bearings and gear
CLEAR = 3.0  # standard deviations


def motorless(whole: Augmented) -> Trial | None:
    """A named coupling of which neither a rotor nor dry friction is clear.

    A fluid, or a hose along two links, drags both by the speed of either, and has nothing else.
    """
    for trial, coefficients, covariance in zip(
        whole.chosen, whole.coefficients, whole.covariances, strict=True
    ):
        if trial.is_free_form or trial.name != MOTOR_COUPLING.name:
            continue
        deviations = np.sqrt(np.diag(at_given_shapes(covariance, len(coefficients))))
        own = [p.name.startswith(OWN) for p in trial.effect.parameters]
        if np.any(own) and np.all(coefficients[own] < CLEAR * deviations[own]):
            return trial
    return None
