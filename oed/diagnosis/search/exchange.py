"""Additions looked at again beside one another: refitted, exchanged, dropped."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import partial
from itertools import combinations

import numpy as np

from oed.diagnosis.candidates.accepted import Accepted, at_home
from oed.diagnosis.candidates.calming import worth_beside
from oed.diagnosis.candidates.crests import climbed
from oed.diagnosis.candidates.judgement import held_out_fault
from oed.diagnosis.candidates.leftovers import too_little
from oed.diagnosis.candidates.open_shapes import decided
from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.candidates.ripening import is_part_of
from oed.diagnosis.candidates.telling import may_replace, replaces
from oed.diagnosis.candidates.usual import as_usual
from oed.diagnosis.search.free_form_rivals import curves_explain_more
from oed.diagnosis.tables.workbench import Layout, early_and_late
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import AT_REST, MOST_ROUNDS, at_rest
from oed.diagnosis.terms.scores import Score, Worth, implausible, score
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.parallel_map import one_by_one

MOST_EXCHANGES = 2  # rounds after each addition; exchanges could go round in circles
MANY = 5  # additions; to look at all of more, again and again, takes minutes
AT_ONCE = 2  # additions that are left out together


def rested(shop: Workshop, accepted: list[Accepted]) -> list[Accepted]:
    """Shapes and reference torque brought to where neither moves the other: what is reported."""
    kept = list(accepted)
    before = np.inf
    for number in range(MOST_ROUNDS):
        trials = [a.trial for a in kept if a.stands_in]
        found = shop.fit(trials, bend=False)
        if found.fit.squares > before - AT_REST:
            break
        before = found.fit.squares
        shop.update_context(found)
        for k, item in enumerate(kept):
            if not item.stands_in or item.trial.is_free_form:
                continue
            others, fit = _beside(shop, kept, item)
            worth = worth_beside(others, fit.rows)
            best = at_rest(score(shop.renewed(item.trial), fit), fit, shop.context, worth)
            if number == 0:
                best = at_rest(climbed(shop, best, fit), fit, shop.context, worth)
            best = as_usual(shop, others, best, fit)
            kept[k] = dataclasses.replace(item, trial=best.trial)
    return kept


def foretelling(shop: Workshop, chosen: Sequence[Trial], late: Trial) -> Trial:
    """A late torque at the shape that foretells best from a motion that is noisy.

    That is less late than the torque is, and an error less where shakes move the arm far.
    """
    fit = shop.fit([t for t in chosen if t.key != late.key], shop.layout(late)).fit
    return at_rest(score(shop.renewed(late), fit), fit, shop.context).trial


def decided_shapes(shop: Workshop, accepted: list[Accepted]) -> list[Accepted]:
    """What the estimation recordings leave open of shapes decided by the validation recordings."""
    kept = list(accepted)
    for k, item in enumerate(kept):
        if not item.stands_in or item.trial.is_free_form:
            continue
        others, fit = _beside(shop, kept, item)
        best = decided(shop, others, score(shop.renewed(item.trial), fit))
        best = as_usual(shop, others, best, fit)
        kept[k] = dataclasses.replace(item, trial=best.trial)
    return kept


def _beside(
    shop: Workshop, accepted: Sequence[Accepted], item: Accepted
) -> tuple[list[Trial], LinearFit]:
    """What else is part of the model, and the fit with it, on the rows of an addition."""
    others = [a.trial for a in accepted if a.stands_in and a is not item]
    return others, shop.fit(others, shop.layout(item.trial)).fit


def settled(
    shop: Workshop,
    accepted: list[Accepted],
    pool: Sequence[Trial],
    fresh: Sequence[Accepted] = (),
) -> list[Accepted]:
    """Refit, re-examine each addition beside the others, exchange or drop it.

    Of very many, those alone that act on a joint on which something is fresh.

    Args:
        shop: The laid-out data.
        accepted: Additions so far.
        pool: Candidates, over the grids of their shapes.
        fresh: What was added since they were looked at; all if empty.
    """
    moved = {joint for item in fresh for joint in item.trial.group}
    for _ in range(MOST_EXCHANGES):
        trials = [a.trial for a in accepted]
        shop.update_context(shop.fit(trials, bend=False))
        accepted = [at_home(shop, a) for a in accepted]
        places = [
            k
            for k, a in enumerate(accepted)
            if not fresh or len(accepted) <= MANY or not moved.isdisjoint(a.trial.group)
        ]
        accepted = _looked_at(shop, accepted, places, pool)
        if [a.trial.key for a in accepted] == [t.key for t in trials]:
            break
    return _best_subset(shop, accepted)


def _looked_at(
    shop: Workshop, accepted: list[Accepted], places: list[int], pool: Sequence[Trial]
) -> list[Accepted]:
    """The additions, those in some places refined or exchanged one after another.

    As long as none moves, others may be looked at side by side with it.
    """
    gains = [a.gain for a in accepted]
    while places:
        best_in = partial(_best_in_place, shop, accepted, pool)
        done = 0
        for k, best in zip(places, one_by_one(best_in, places), strict=True):
            done += 1
            gains[k] = best.gain
            if not _is_same(best.trial, accepted[k].trial):
                accepted = [*accepted[:k], best, *accepted[k + 1 :]]
                break
        places = places[done:]
    return [dataclasses.replace(a, gain=g) for a, g in zip(accepted, gains, strict=True)]


def _is_same(one: Trial, other: Trial) -> bool:
    return one.key == other.key and one.values == other.values


def _best_subset(shop: Workshop, accepted: list[Accepted]) -> list[Accepted]:
    """The additions that the evidence needs: two that cancel both go."""
    penalty = np.log(shop.full.rows.count)

    def cost(chosen: Sequence[Accepted], layout: Layout) -> float:
        found = shop.fit([a.trial for a in chosen], layout)
        return found.fit.squares + penalty * found.fit.projection.rank

    def more(chosen: Sequence[Accepted]) -> float:
        # On the rows that show what is left out: the mean of repetitions tells most of the rest.
        left_out = [a.trial for a in best if all(a is not c for c in chosen)]
        layout = shop.layout_for(left_out)
        return cost(chosen, layout) - cost(best, layout)

    best = accepted
    while len(best) > 1:
        sizes = range(max(len(best) - AT_ONCE, 1), len(best))
        smaller = [list(c) for size in sizes for c in combinations(best, size)]
        costs = [more(c) for c in smaller]
        # A larger set must be better by a margin, since it had more chances.
        if min(costs) > shop.settings.decisive:
            break
        best = smaller[costs.index(min(costs))]
    return best


def _best_in_place(
    shop: Workshop, accepted: list[Accepted], pool: Sequence[Trial], place: int
) -> Accepted:
    """The addition in a place with its shape refined, or a better one for its place."""
    current, rest = accepted[place], [*accepted[:place], *accepted[place + 1 :]]
    others = [a.trial for a in rest]
    fit = shop.fit(others, shop.layout(current.trial)).fit
    worth = worth_beside(others, fit.rows)
    start = score(shop.renewed(current.trial), fit)
    here = as_usual(shop, others, at_rest(start, fit, shop.context, worth), fit)
    if _is_at_rest(shop, start, here, worth):
        here = start
    if not others or current.trial.is_free_form:
        return Accepted(here.trial, here.gain)
    # Of any joint: what is better by far elsewhere may be why this one looked needed.
    for rival in [
        *_plainer_gears(shop, current.trial, others, pool),
        *ranked(shop, pool, others, 2),
    ]:
        if rival.trial.key == here.trial.key or not may_replace(shop, here, rival):
            continue
        if early_and_late([*others, rival.trial]) and not early_and_late(others):
            continue
        if (
            replaces(shop, others, here, rival)
            and too_little(shop, rival, rest) is None
            and implausible(rival, shop.context) is None
            and held_out_fault(shop, others, rival.trial) is None
            and curves_explain_more(shop, rival, others) is None
        ):
            return Accepted(rival.trial, rival.gain)
    return Accepted(here.trial, here.gain)


def _is_at_rest(shop: Workshop, start: Score, here: Score, worth: Worth) -> bool:
    """Whether the shape of an addition is as good as the one that it would come to."""
    if start.freedom != here.freedom or implausible(start, shop.context) is not None:
        return False
    return 0 <= worth(here) - worth(start) < AT_REST


def _plainer_gears(
    shop: Workshop, current: Trial, others: Sequence[Trial], pool: Sequence[Trial]
) -> list[Score]:
    """Gears that are part of one, on the torque that they leave.

    A gap that was found before a delay was known may have been a spring and that delay.
    """
    plainer = [t for t in pool if is_part_of(t, current)]
    return ranked(shop, plainer, others, 1, thorough=True) if plainer else []
