"""The torque of the explanation that is taken for true, and what a rival makes of it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.tables.workbench import Layout, fit_layout, layout_of
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import refine
from oed.diagnosis.terms.scores import Score, score
from oed.diagnosis.terms.trials import Trial, catalogue_trial, dense, grid_of, white_group
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.context import Context
from oed.experiment.preparation.prepared import Prepared
from oed.parallel_map import side_by_side

# Favourite, its coefficients, and rival.
Pair = tuple[Trial, Float[ndarray, " columns"], Trial]


def torque_beside(shop: Workshop, pair: Pair, further: Prepared | None) -> LinearFit:
    """The favourite's white torque, fitted with base model and nuisances alone.

    Args:
        shop: The data at hand, and their noise.
        pair: Favourite, its coefficients, and rival.
        further: A recording besides those at hand, run as often as the first of these.
    """
    favourite, coefficients, rival = pair
    layout = with_further(shop, shop.layout_for([favourite, rival]), further)
    return torque_on(shop, layout, favourite, coefficients)


def torque_on(
    shop: Workshop, layout: Layout, favourite: Trial, coefficients: Float[ndarray, " columns"]
) -> LinearFit:
    """The same on rows that are laid out already."""
    # The effect as it was fitted: one that acts on the model's torque brings its own.
    mine = dataclasses.replace(favourite, group=white_group(favourite.effect, layout.rows))
    torque = dense(mine, shop.context.n, layout.rows.count) @ coefficients
    return fit_layout(shop.baseline, layout, layout.span, torque)


def context_beside(shop: Workshop, further: Prepared | None) -> Context:
    """What is known if one more recording is: how far shapes reach hangs on the motion."""
    return shop.context if further is None else shop.context.covering(further.motion)


def best_imitations(context: Context, rival: Trial, fits: Sequence[LinearFit]) -> list[Score]:
    """The rival with the shape that explains each favourite's torque best, of their whole range.

    Args:
        context: Of `context_beside`.
        rival: With the shape that explains the data.
        fits: Of the favourites' torques, on the same rows, by `torque_beside`.
    """
    entry = CATALOGUE[rival.name]
    shapes = entry.shapes_for(context, rival.target)
    values = [rival.values, *grid_of(shapes)] if shapes else [rival.values]
    tried = [catalogue_trial(entry, context, rival.target, v, fits[0].rows) for v in values]

    def best(fit: LinearFit) -> Score:
        scores = [score(trial, fit) for trial in tried]
        # From where the rival stands, and from the best of the grid: there is more than one valley.
        starts = {s.trial.values: s for s in (scores[0], max(scores, key=lambda s: s.gain))}
        return max((refine(s, fit, context) for s in starts.values()), key=lambda s: s.gain)

    return side_by_side(best, fits)


def with_further(shop: Workshop, layout: Layout, further: Prepared | None) -> Layout:
    """A layout and one more recording, if there is one."""
    if further is None:
        return layout
    old, scale = layout.rows, layout.rows.scales[0]
    new = layout_of(shop.baseline, shop.baseline.rows((further,), (scale,)))
    weights = np.concatenate([old.weights, new.rows.weights])
    hidden = (*old.hidden, *new.rows.hidden)
    rows = Rows((*old.prepared, further), old.noise, (*old.scales, scale), weights, hidden)
    blocks = (
        (layout.regressor, new.regressor),
        (layout.nuisances, new.nuisances),
        (layout.torque, new.torque),
    )
    return Layout(rows, *(np.concatenate(pair, axis=1) for pair in blocks))
