"""From selected additions to an ordinary torque model with their exact form."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.turning import GRAVITY
from oed.diagnosis.tables.workbench import Augmented, Layout, lags_of
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.noise.baseline import Baseline
from oed.diagnosis_new.noise.linear_fit import LinearFit, fit_model
from oed.dynamics.effects.catalogue import CATALOGUE, Context
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepared import Prepared


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


def final_with(shop: Workshop, found: Augmented) -> FinalModel:
    """The base model with some additions in their exact form, all fitted together.

    Args:
        shop: The laid-out data.
        found: The additions, fitted on the rows that show them.
    """
    model = install(shop.baseline, found, shop.context)
    return fit_final(shop.baseline, shop.layout_for(found.chosen), model)


def errors_of(final: FinalModel, prepared: Sequence[Prepared]) -> list[Float[ndarray, "_ joints"]]:
    """Torque less prediction in the analysis band [N m], one array a recording."""
    return [e[p.valid] for e, p in zip(_all_errors(final, prepared), prepared, strict=True)]


def lost_when_repeated(shop: Workshop, found: Augmented, final: FinalModel) -> Trial | None:
    """An addition that mends the mean of repetitions, and makes single ones worse, foretold ones too.

    A disturbance of one repetition moves the arm a little: in the mean of several, friction turns
    its sign more gradually than in any. What explains that is no part of the arm. A sensor that is
    late is so with the disturbance too, which single repetitions hold: nothing is asked of it. A
    free-form term of its joint, which may follow anything, is no reason against a name.

    Args:
        shop: The laid-out data.
        found: The additions, fitted.
        final: With all of them in their exact form.
    """
    if shop.mean is shop.full or not found.chosen:
        return None
    every = _white_squares(shop, final)
    for trial in found.chosen:
        if lags_of([trial]) or (trial.name == GRAVITY and shop.is_turned):
            continue
        rest = [t for t in found.chosen if t is not trial]
        others = [t for t in rest if trial.is_free_form or not t.may_follow(trial)]
        whole = every
        if len(others) < len(rest):
            whole = _white_squares(shop, final_with(shop, shop.fit([*others, trial])))
        without = _white_squares(shop, final_with(shop, shop.fit(others)))
        if np.sum((without - whole)[list(trial.group)]) <= 0:
            return trial
    return None


def _white_squares(shop: Workshop, final: FinalModel) -> Float[ndarray, " joints"]:
    """(n,) squares of white errors of all rows, repeated or not, that were fitted or foretold."""
    joints = range(shop.baseline.model.robot.n)
    total = np.zeros(len(joints))
    for rows in filter(None, (shop.full.rows, shop.unseen_full.rows)):
        errors = _all_errors(final, rows.prepared)
        total += [np.sum(rows.whiten([e[:, [j]] for e in errors], j) ** 2) for j in joints]
    return total


def _all_errors(
    final: FinalModel, prepared: Sequence[Prepared]
) -> list[Float[ndarray, "_ joints"]]:
    """Of every row, next to gaps of the log too."""
    torques = (final.model.torque(final.parameters, p.motion) for p in prepared)
    return [p.torque - p.band.apply(t) for p, t in zip(prepared, torques, strict=True)]


def _acts_on_model(trial: Trial) -> bool:
    return not trial.is_free_form and CATALOGUE[trial.name].install is not None
