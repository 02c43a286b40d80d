"""How sharply friction turns where a joint reverses: a shape of the base model, refitted beside the rest."""

from __future__ import annotations

import dataclasses

import numpy as np

from oed.diagnosis_new.evidence.views import Views, Which
from oed.diagnosis_new.noise.sign_width import with_fitted_sign
from oed.diagnosis_new.numbers import PREDICTION_GAIN
from oed.diagnosis_new.problem import Problem


def sharpened(views: Views, which: Which) -> Views:
    """The model whose base's signs turn over the velocities that fit best beside all its terms.

    Args:
        views: A model; its means show a sign's turn best.
        which: Rows that are fitted.
    """
    problem, means = views.problem, views.means
    if means.installed.measurement or means.installed.robot is not problem.base.robot:
        return views
    count = len(means.columns) + means.problem.nuisances.shape[2]
    beside = np.concatenate(
        [means.problem.nuisances, means.projection.columns[:, :, count:]], axis=2
    )
    base = with_fitted_sign(problem.sharpest, problem.columns, means.problem.rows.rows, beside)
    if base == problem.base:
        return views

    def turned(own: Problem) -> Problem:
        return dataclasses.replace(
            own, base=base, context=dataclasses.replace(own.context, model=base)
        )

    again = turned(problem)
    if problem.means is not None:
        again = dataclasses.replace(again, means=turned(problem.means))
    sharper = Views.of(again, views.terms, which, views)
    return sharper if sharper.score(which) > views.score(which) + PREDICTION_GAIN else views
