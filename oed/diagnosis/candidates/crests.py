"""The best shape of an addition, looked for from every crest of its grid.

A simplex climbs the crest where it begins. Friction that rises with less than the first power of
speed looks much like viscous friction less a higher power: far apart in shape, close in gain.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from itertools import product

import numpy as np
from scipy.ndimage import maximum_filter

from oed.diagnosis.candidates.ripening import is_late, is_unripe
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import refine
from oed.diagnosis.terms.scores import Score, implausible, score
from oed.diagnosis.terms.trials import Trial, moved
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.dynamics.effects.catalogue import CATALOGUE

MOST = 4  # crests of a grid that are climbed


def climbed(shop: Workshop, found: Score, fit: LinearFit) -> Score:
    """A candidate at its best shape, or a better one that another crest leads to.

    What acts on its own torque is left where it is: its grid stands on another torque.
    """
    if not found.trial.shapes or is_unripe(found.trial) or is_late(found.trial):
        return found
    grid = _scanned_finely(shop, found, fit) or [
        score(_with_choice(shop, t, found.trial, fit), fit)
        for t in shop.physical
        if t.key == found.trial.key and t.contrast == found.trial.contrast
    ]
    tried = [refine(s, fit, shop.context) for s in crests(grid)[:MOST]]
    plausible = [s for s in tried if implausible(s, shop.context) is None]
    # By evidence: of two that explain as much, the one that does not trade places with the model.
    return max([found, *plausible], key=lambda s: s.evidence(fit.rows.count))


def _with_choice(shop: Workshop, trial: Trial, chosen: Trial, fit: LinearFit) -> Trial:
    """A point of the grid with the clock that was chosen where these rows leave none to choose."""
    shapes = CATALOGUE[trial.name].shapes_for(shop.context, trial.target)
    values = tuple(
        own if shape.scale == "choice" and shape.points == 1 else value
        for shape, value, own in zip(shapes, trial.values, chosen.values, strict=True)
    )
    if values == trial.values:
        return trial
    there = dataclasses.replace(trial, values=values)
    return moved(there, fit.rows, shop.context, contrast=trial.contrast)


def _scanned_finely(shop: Workshop, found: Score, fit: LinearFit) -> list[Score]:
    """A second scan of the shapes that want one, the others as they are."""
    trial = found.trial
    shapes = CATALOGUE[trial.name].shapes_for(shop.context, trial.target)
    if not any(shape.fine for shape in shapes):
        return []
    ways = [
        dataclasses.replace(shape, points=shape.fine).grid if shape.fine else (value,)
        for shape, value in zip(shapes, trial.values, strict=True)
    ]
    there = (dataclasses.replace(trial, values=values) for values in product(*ways))
    return [score(moved(t, fit.rows, shop.context, contrast=trial.contrast), fit) for t in there]


def crests(scores: Sequence[Score]) -> list[Score]:
    """Grid points of one candidate that none of their neighbours exceeds, the best first."""
    places = np.array([s.trial.values for s in scores]).T
    at = tuple(np.unique(own, return_inverse=True)[1] for own in places)
    gains = np.full([own.max() + 1 for own in at], -np.inf)
    gains[at] = [s.gain for s in scores]
    is_crest = (gains == maximum_filter(gains, size=3, mode="nearest"))[at]
    own = [s for s, top in zip(scores, is_crest, strict=True) if top]
    return sorted(own, key=lambda s: -s.gain)
