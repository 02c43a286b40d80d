"""Candidates that act on the model's own torque, judged on the torque that they leave.

A spring or a gap is tried on the rigid torque of a fit that does not know it. Where the effect
is large that fit is wrong, and so is what the spring would make of it. Fit, evaluate anew and
refine in turn, and the candidate shows what it is worth.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.optimize import differential_evolution

from oed.diagnosis.candidates.calming import worth_beside
from oed.diagnosis.tables.workbench import lags_of
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import refine, score_at
from oed.diagnosis.terms.scores import Score, Worth, gain_of, implausible, score
from oed.diagnosis.terms.trials import Trial, moved
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.dynamics.effects.catalogue import CATALOGUE, Context
from oed.parallel_map import side_by_side

STARTS = 3  # parts of the first shape's range that are each searched
KEPT = 2  # of these that are evaluated anew
ROUNDS = 4  # of the best of them
POPULATION = 12  # members for each shape where a simplex stops on a lesser crest
GENERATIONS = 22
PROMISED = 1e-3  # of what a free size would gain counts where a fixed one gains nothing
SEED = 1  # of the population
MOST_ROUNDS = 8
SETTLED = 0.3  # gain of a round, far below what decides between two names
WORTH = 1.01  # ratio by which a round must raise the gain to be followed by another


def is_unripe(trial: Trial) -> bool:
    """Whether a trial's columns stand on the reference torque alone, and bend it much."""
    return not trial.is_free_form and (
        CATALOGUE[trial.name].unit_coefficient and trial.joint is not None
    )


def is_late(trial: Trial) -> bool:
    """Whether a trial makes the torque of the whole arm late."""
    return bool(lags_of([trial]))


def ripened(
    shop: Workshop, scores: Sequence[Score], others: Sequence[Trial], fit: LinearFit
) -> Score:
    """The best of one candidate, its reference torque taken from a fit with it.

    Args:
        shop: The laid-out data.
        scores: All grid points of one candidate.
        others: Additions that it stands beside.
        fit: With these others, without it.
    """
    if is_late(scores[0].trial):
        return _late_at_rest(shop, max(scores, key=lambda s: s.gain), others, fit)
    refined = side_by_side(lambda s: refine(s, fit, shop.context), starts(scores))
    tried = sorted(refined, key=lambda s: -s.gain)[:KEPT]
    evaluated = side_by_side(lambda s: _on_what_it_leaves(shop, s, others, fit), tried)
    return _followed(shop, max(evaluated, key=lambda s: s.gain), others, fit)


def where_it_ended(
    shop: Workshop, richer: Score, plainer: Trial, others: Sequence[Trial], fit: LinearFit
) -> Score:
    """A gear that is part of another, refined by its plain formula from where that has ended.

    Args:
        shop: The laid-out data.
        richer: A ripened gear.
        plainer: One that is part of it.
        others: Additions that both stand beside.
        fit: With these others, without either.
    """
    ended = dict(zip(_shape_names(richer.trial), richer.trial.values, strict=True))
    shapes = CATALOGUE[plainer.name].shapes_for(shop.context, plainer.target)
    values = tuple(min(max(ended.get(s.name, s.default), s.lower), s.upper) for s in shapes)
    start = moved(dataclasses.replace(plainer, values=values), fit.rows, shop.context)
    best = _on_what_it_leaves(shop, score(start, fit), others, fit)
    return _followed(shop, best, others, fit)


def is_part_of(plainer: Trial, richer: Trial) -> bool:
    """Whether a gear at the joint of another has some of its shapes, and by its plain formula no others."""
    if plainer.target != richer.target or not (is_unripe(plainer) and is_unripe(richer)):
        return False
    own = {shape.name for shape in CATALOGUE[plainer.name].shapes if not shape.plain}
    return own < set(_shape_names(richer))


def _shape_names(trial: Trial) -> list[str]:
    return [shape.name for shape in CATALOGUE[trial.name].shapes]


def has_crests(found: Score) -> bool:
    """Whether a candidate is a gear on one of whose shapes a simplex may stop on a lesser crest."""
    trial = found.trial
    return is_unripe(trial) and any(shape.rugged for shape in CATALOGUE[trial.name].shapes)


def searched(shop: Workshop, found: Score, others: Sequence[Trial], fit: LinearFit) -> Score:
    """A ripened candidate, or the better one that a population of its shapes finds."""
    best = _on_what_it_leaves(shop, _of_population(found.trial, fit, shop.context), others, fit)
    return max(found, _followed(shop, best, others, fit), key=lambda s: s.gain)


def _followed(shop: Workshop, best: Score, others: Sequence[Trial], fit: LinearFit) -> Score:
    """Rounds until one gains little."""
    for _ in range(ROUNDS):
        again = _on_what_it_leaves(shop, best, others, fit)
        is_last = again.gain < WORTH * best.gain
        best = max(best, again, key=lambda s: s.gain)
        if is_last:
            break
    return best


def _of_population(trial: Trial, fit: LinearFit, context: Context) -> Score:
    """The best of many shapes, by differential evolution.

    Whether a gap is crossed here or a little later hangs on every shape at once: a simplex stops
    on one of the many crests.
    """

    def loss(x: Float[ndarray, " shapes"]) -> float:
        found = score_at(x, trial, fit, context)
        if implausible(found, context) is not None:
            return 0.0
        return -found.gain if found.gain > 0 else -PROMISED * found.promise

    found = differential_evolution(
        loss,
        [(0.0, 1.0)] * trial.shapes,
        popsize=POPULATION,
        maxiter=GENERATIONS,
        init="sobol",
        strategy="currenttobest1bin",  # misses the best crest least often of those tried
        polish=False,
        rng=np.random.default_rng(SEED),
    )
    return score_at(found.x, trial, fit, context)


def _late_at_rest(shop: Workshop, found: Score, others: Sequence[Trial], fit: LinearFit) -> Score:
    """A delay or a lag evaluated until it gains nothing that could tell one from the other."""
    worth = worth_beside(others, fit.rows)
    best = _on_what_it_leaves(shop, refine(found, fit, shop.context, worth), others, fit, worth)
    for _ in range(MOST_ROUNDS):
        again = _on_what_it_leaves(shop, best, others, fit, worth)
        settled = worth(again) < worth(best) + SETTLED
        best = max(best, again, key=worth)
        if settled:
            break
    return best


def _on_what_it_leaves(
    shop: Workshop,
    found: Score,
    others: Sequence[Trial],
    fit: LinearFit,
    worth: Worth = gain_of,
) -> Score:
    """The candidate on the reference torque of a fit with it."""
    layout = shop.layout(found.trial)
    whole = shop.fit([*others, found.trial], layout, bend=False)
    context = shop.context_with(whole)
    trial = moved(found.trial, layout.rows, context, contrast=found.trial.contrast)
    return refine(score(trial, fit), fit, context, worth)


def starts(scores: Sequence[Score]) -> list[Score]:
    """The best grid point of each part of the first shape's range."""
    values = np.unique([s.trial.values[0] for s in scores])
    parts = np.array_split(values, min(STARTS, len(values)))
    return [
        max((s for s in scores if s.trial.values[0] in part), key=lambda s: s.gain)
        for part in parts
    ]
