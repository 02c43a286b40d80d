"""Shapes that machines are built with, and plain formulas, where the data do not speak against them.

A motor that turns with two joints of a wrist does so by a pair of gears of equal size as a rule. In
a short recording its friction turns its sign at few samples, and the best ratio is an accident. So
is the second shape of a family of formulas where the first does as well: both trade places, and the
best pair of them may be far from either.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

from oed.diagnosis.candidates.margin import decisive_between
from oed.diagnosis.candidates.telling import telling
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import climb, shorter_formulas
from oed.diagnosis.terms.scores import Score, implausible, score
from oed.diagnosis.terms.trials import Trial, moved
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.dynamics.effects.catalogue import CATALOGUE, Shape


def as_usual(shop: Workshop, others: Sequence[Trial], found: Score, fit: LinearFit) -> Score:
    """A candidate as machines are built and by its plain formula, unless the data tell more else.

    Args:
        shop: The laid-out data.
        others: Additions that it stands beside.
        found: At its best shape.
        fit: With those additions.
    """
    return _by_plain_formula(shop, others, _as_built(shop, others, found, fit), fit)


def plainer(shop: Workshop, others: Sequence[Trial], trial: Trial) -> Trial | None:
    """An addition by the best plausible one of its formulas that have fewer terms; None if none is.

    Args:
        shop: The laid-out data.
        others: Additions that it stands beside.
        trial: The addition.
    """
    fit = shop.fit(others, shop.layout(trial)).fit
    here = score(shop.renewed(trial), fit)
    fewer = [climb(s, fit, shop.context) for s in shorter_formulas(here, fit, shop.context)]
    plausible = [s for s in fewer if implausible(s, shop.context) is None]
    return max(plausible, key=lambda s: s.gain).trial if plausible else None


def _as_built(shop: Workshop, others: Sequence[Trial], found: Score, fit: LinearFit) -> Score:
    usual = [
        score(_with_shape(shop, found.trial, fit, place, value), fit)
        for place, shape in _shapes(shop, found.trial)
        for value in shape.usual
    ]
    usual = [s for s in usual if implausible(s, shop.context) is None]
    if not usual:
        return found
    (own, *values), unit = telling(shop, others, [found, *usual])
    best, value = max(zip(usual, values, strict=True), key=lambda pair: pair[1])
    return best if value > own - decisive_between(shop, found, best, unit) else found


def _by_plain_formula(
    shop: Workshop, others: Sequence[Trial], found: Score, fit: LinearFit
) -> Score:
    """A candidate with every further shape of its family idle that the data do not ask for."""
    for place, shape in _shapes(shop, found.trial):
        if not shape.plain or found.trial.values[place] == shape.default:
            continue
        there = score(_with_shape(shop, found.trial, fit, place, shape.default), fit)
        plain = climb(there, fit, shop.context, held=place)
        if implausible(plain, shop.context) is not None:
            continue
        (own, value), _ = telling(shop, others, [found, plain])
        if value > own - shop.settings.decisive:
            found = plain
    return found


def _shapes(shop: Workshop, trial: Trial) -> Iterator[tuple[int, Shape]]:
    if not trial.is_free_form:
        yield from enumerate(CATALOGUE[trial.name].shapes_for(shop.context, trial.target))


def _with_shape(shop: Workshop, trial: Trial, fit: LinearFit, place: int, value: float) -> Trial:
    values = (*trial.values[:place], value, *trial.values[place + 1 :])
    there = dataclasses.replace(trial, values=values)
    return moved(there, fit.rows, shop.context, contrast=trial.contrast)
