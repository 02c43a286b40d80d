"""Shapes that machines are built with, taken where the data do not speak against them.

A motor that turns with two joints of a wrist does so by a pair of gears of equal size as a rule. In
a short recording its friction turns its sign at few samples, and the best ratio is an accident.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

from oed.diagnosis.fit.linear_fit import LinearFit
from oed.diagnosis.search.margin import decisive_between
from oed.diagnosis.search.scan import Score, implausible, score
from oed.diagnosis.search.telling import telling
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.terms.trials import Trial, moved
from oed.dynamics.effects.catalogue import CATALOGUE


def as_built(shop: Workshop, others: Sequence[Trial], found: Score, fit: LinearFit) -> Score:
    """A candidate with a usual shape, unless the data tell far more of its own.

    Args:
        shop: The laid-out data.
        others: Additions that it stands beside.
        found: At its best shape.
        fit: With those additions.
    """
    usual = [
        s
        for s in (score(t, fit) for t in _usual(shop, found.trial, fit))
        if implausible(s, shop.context) is None
    ]
    if not usual:
        return found
    (own, *values), unit = telling(shop, others, [found, *usual])
    best, value = max(zip(usual, values, strict=True), key=lambda pair: pair[1])
    return best if value > own - decisive_between(shop, found, best, unit) else found


def _usual(shop: Workshop, trial: Trial, fit: LinearFit) -> Iterator[Trial]:
    if trial.is_free_form:
        return
    shapes = CATALOGUE[trial.name].shapes_for(shop.context, trial.target)
    for place, shape in enumerate(shapes):
        for value in shape.usual:
            values = (*trial.values[:place], value, *trial.values[place + 1 :])
            there = dataclasses.replace(trial, values=values)
            yield moved(there, fit.rows, shop.context, contrast=trial.contrast)
