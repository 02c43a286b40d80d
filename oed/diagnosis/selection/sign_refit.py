"""How sharply friction turns where a joint reverses: a shape of the base model, refitted beside the rest."""

from __future__ import annotations

import dataclasses

from oed.diagnosis.evidence.views import Views, Which
from oed.diagnosis.numbers import PREDICTION_GAIN
from oed.diagnosis.problem import Problem
from oed.dynamics.velocity_sign import signs_of, widths_of, with_signs, with_widths
from oed.estimation.noise_floor.sign_width import with_fitted_sign


def with_refitted_sign(views: Views, which: Which) -> Views:
    """The model whose base's signs turn over the velocities that fit best beside all its terms.

    Args:
        views: A model; its means show a sign's turn best.
        which: Rows that are fitted.
    """
    problem, means = views.problem, views.means
    count = len(means.columns)
    beside = means.projection.columns[:, :, count:]
    # A lag moves where friction turns: both are seen through what is installed.
    start = with_widths(means.installed, widths_of(problem.sharpest))
    found = with_fitted_sign(start, means.columns, means.problem.rows.rows, beside)
    base = with_signs(problem.base, signs_of(found))
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
