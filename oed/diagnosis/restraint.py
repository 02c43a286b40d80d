"""What of a free-form term the data determine: the rest is left out, so that it cannot run away.

A spline beside a rigid-body model has combinations of its functions that the model nearly
makes itself. Least squares gives them large values that cancel on the motion at hand and on no
other. A combination stays only where the data know it far better than the size of what is to be
explained would tell (the hard-threshold form of a ridge, Hoerl and Kennard 1970, Technometrics
12(1)).
"""

from __future__ import annotations

import dataclasses

import numpy as np

from oed.diagnosis.free_form import FreeForm
from oed.diagnosis.linear_fit import LinearFit, gram_and_moment
from oed.diagnosis.trials import Trial

KNOWN = 3.0  # standard deviations that a function of the residual's size must measure


def restrained(trial: Trial, fit: LinearFit) -> Trial | None:
    """The term with its determined combinations alone; None if there are none.

    Args:
        trial: A free-form term, its group on the rows of the fit.
        fit: Of the model before it.

    Raises:
        TypeError: If the trial is no free-form term.
    """
    effect = trial.effect
    if not isinstance(effect, FreeForm):
        raise TypeError(f"{trial.name} is no free-form term")
    joint = effect.joint
    noise, scale = fit.rows.noise[joint], fit.rows.scales[0]
    weight = max(float(np.sum(fit.rows.weights[:, joint] ** 2)), 1.0)
    white = np.sqrt(np.sum(fit.residual[joint] ** 2) / weight)
    size = white * noise.deviation * scale  # [N m], of the residual on these rows
    (gram, _), _ = gram_and_moment(fit.projection, fit.residual, trial.group)
    values, vectors = np.linalg.eigh(gram)
    kept = values * size**2 > KNOWN**2
    if not kept.any():
        return None
    mixing = vectors[:, kept]
    group = {joint: block @ mixing for joint, block in trial.group.items()}
    return dataclasses.replace(
        trial, effect=dataclasses.replace(effect, mixing=mixing), group=group
    )
