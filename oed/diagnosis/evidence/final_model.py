"""From selected additions to an ordinary torque model with their exact form."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.baseline.baseline import Baseline
from oed.diagnosis.data.prepared import Prepared
from oed.diagnosis.fit.linear_fit import LinearFit, fit_model
from oed.diagnosis.search.workbench import Augmented, Layout
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.effects.catalogue import CATALOGUE, Context
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel


@dataclass(frozen=True)
class FinalModel:
    """The augmented model, every linear parameter fitted together.

    Attributes:
        model: With the effects in their exact form.
        parameters: (p,) of all its columns, regrouped ones at zero.
        fit: To the whitened rows.
    """

    model: TorqueModel
    parameters: Float[ndarray, " parameters"]
    fit: LinearFit


def install(baseline: Baseline, found: Augmented, context: Context) -> TorqueModel:
    """The base model with all additions in their exact form.

    Effects that are columns go first, so that those acting on the whole model see them.
    """
    model, parameters = baseline.model, found.fit.full_parameters()
    pairs = list(zip(found.chosen, found.coefficients, strict=True))
    for trial, coefficients in sorted(pairs, key=lambda pair: _acts_on_model(pair[0])):
        before = len(model.parameters)
        if trial.is_free_form:
            model = model.with_effects(trial.effect)
        else:
            here = dataclasses.replace(context, model=model, parameters=parameters, beside=())
            entry = CATALOGUE[trial.name]
            model = entry.apply(here, trial.target, trial.values, coefficients)
        added = len(model.parameters) - before
        if added:
            parameters = np.concatenate([parameters, coefficients[:added]])
    return model


def fit_final(baseline: Baseline, layout: Layout, model: TorqueModel) -> FinalModel:
    """Fit all linear parameters of the installed model together: friction moves inertias."""
    count = len(baseline.model.parameters)
    added = np.arange(count, len(model.parameters))
    if model.robot is baseline.model.robot:
        base = baseline.columns
    else:
        # Another direction of gravity makes other combinations visible.
        bare = dataclasses.replace(model, effects=model.effects[: len(baseline.model.effects)])
        base = np.sort(base_parameters(dataclasses.replace(bare, measurement=())).columns)
    columns = np.concatenate([base, added])
    fit = fit_model(model, columns, layout.rows)
    return FinalModel(model, fit.full_parameters(), fit)


def errors_of(final: FinalModel, prepared: Sequence[Prepared]) -> list[Float[ndarray, "_ joints"]]:
    """Torque less prediction in the analysis band [N m], one array a recording."""
    return [
        (p.torque - p.band.apply(final.model.torque(final.parameters, p.motion)))[p.valid]
        for p in prepared
    ]


def _acts_on_model(trial: Trial) -> bool:
    return not trial.is_free_form and CATALOGUE[trial.name].install is not None
