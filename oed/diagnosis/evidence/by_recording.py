"""How far recordings differ in the shape that each of them wants.

The gain of a gap has crests: links that land a sample sooner or later land well or badly. About
the crest that was taken the fit is as sharp as its noise, and the next one, some percent off, is
almost as good, or better in another recording. No slope tells of that. What each recording wants
by itself does: their spread gives the deviation of what they want together.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import norm, t

from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.dynamics.effects.catalogue import CATALOGUE, Context

REACH = 0.09  # of a shape's range, to each side of its estimate
STEPS = 60  # over both sides
SHARE = 0.975  # one-sided, of an interval of 95 %


def rugged_shapes(trial: Trial, context: Context) -> list[int]:
    """Places of an addition's shapes whose gain has crests."""
    if not trial.shapes:
        return []
    shapes = CATALOGUE[trial.name].shapes_for(context, trial.target)
    return [k for k, shape in enumerate(shapes) if shape.rugged]


def spread_by_recording(shop: Workshop, found: Augmented, number: int, place: int) -> float:
    """Deviation of a shape on its axis, from what each recording wants; 0 with fewer than two.

    Estimation and validation recordings alike; the other shapes stay, all sizes are fitted anew.
    Few recordings tell little of their own spread: Student's t is in it, so that two deviations
    still make an interval of 95 %.

    Args:
        shop: The laid-out data.
        found: The additions, fitted.
        number: Of the addition.
        place: Of its shape.
    """
    trial = found.chosen[number]
    shape = CATALOGUE[trial.name].shapes_for(shop.context, trial.target)[place]
    here = shape.place_of(trial.values[place])
    axes = np.clip(here + np.linspace(-REACH, REACH, STEPS + 1), 0.0, 1.0)
    left = []
    for axis in axes:
        values = list(trial.values)
        values[place] = shape.at(float(axis))
        chosen = list(found.chosen)
        chosen[number] = shop.renewed(dataclasses.replace(trial, values=tuple(values)))
        left.append(_left_of_recordings(shop, shop.fit(chosen, bend=False)))
    wanted = axes[np.argmin(left, axis=0)]
    count = len(wanted)
    if count < 2:
        return 0.0
    student = t.ppf(SHARE, count - 1) / norm.ppf(SHARE)
    grid = 2 * REACH / STEPS / np.sqrt(12)
    return float(np.hypot(student * np.std(wanted, ddof=1) / np.sqrt(count), grid))


def _left_of_recordings(shop: Workshop, found: Augmented) -> Float[ndarray, " recordings"]:
    """White squares that a fit leaves of each recording, seen or foretold."""
    unseen = shop.unseen_by(found.chosen)
    left = _by_recording(found.fit.residual, found.fit.rows)
    if unseen.rows is None:
        return left
    return np.concatenate([left, _by_recording(unseen.errors(found), unseen.rows)])


def _by_recording(
    white: Float[ndarray, "joints rows"], rows: Rows
) -> Float[ndarray, " recordings"]:
    return np.add.reduceat(np.sum(white**2, axis=0), rows.starts[:-1])
