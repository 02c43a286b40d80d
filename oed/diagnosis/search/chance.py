"""How likely chance alone is to explain as much as a candidate, over a whole search."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.fit.linear_fit import LinearFit
from oed.diagnosis.search.scan import Score, inflation_of
from oed.diagnosis.search.surrogates import (
    family_p_value,
    flipped,
    largest_surprises,
    moved_in_time,
)
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.terms.trials import Trial

# Residuals that chance might have left, of a fit and so many.
Draw = Callable[[LinearFit, int, np.random.Generator], Float[ndarray, "joints rows count"]]


def p_value_of(
    shop: Workshop, candidate: Score, others: Sequence[Trial], pool: Sequence[Trial]
) -> float:
    """Family-wise p-value; chance is what the model with the candidate leaves of its joints."""
    own = candidate.trial
    after = shop.fit([*others, own], shop.layout(own)).fit
    return _family_wise(shop, candidate, after, flipped, pool)


def chance_of_slow_noise(
    shop: Workshop, candidate: Score, others: Sequence[Trial], pool: Sequence[Trial]
) -> float:
    """Family-wise p-value of noise so slow that a curve of the arm's state can follow it.

    What a term has taken for the arm's doing is gone from what it leaves. So chance is what was
    there before, moved in time: noise keeps no step with the arm, and a search finds as much in it.
    """
    before = shop.fit(others, shop.layout(candidate.trial)).fit
    return _family_wise(shop, candidate, before, moved_in_time, pool)


def keeps_step(shop: Workshop, others: Sequence[Trial], joint: int) -> bool:
    """Whether what additions leave of a joint keeps step with the arm; slow noise may not.

    Always where repetitions show what noise is.
    """
    if shop.mean is not shop.full:
        return True
    fit = shop.fit(others, shop.mean).fit
    own = [t for t in (*shop.smooth, *shop.smooth_pairs) if t.joint == joint]
    left = float(largest_surprises(own, fit, fit.residual[:, :, None])[0])
    return shop.context.n * _chance_of(shop, left, own, fit, moved_in_time) <= shop.settings.level


def _family_wise(
    shop: Workshop,
    candidate: Score,
    fit: LinearFit,
    draw: Draw,
    pool: Sequence[Trial],
) -> float:
    """Chance that a search of a candidate's joints surprises as much.

    A search through its joints, and Bonferroni's factor for the others: what they lack, and how
    slowly that changes, says nothing of chance here.
    """
    own = candidate.trial
    kin = [
        t
        for t in pool
        if t.between_repetitions == own.between_repetitions
        and not set(t.group).isdisjoint(own.group)
    ]
    surprise = candidate.surprise(inflation_of(fit))
    places = shop.context.n / len(own.group)
    return min(1.0, places * _chance_of(shop, surprise, kin, fit, draw))


def _chance_of(
    shop: Workshop, surprise: float, kin: Sequence[Trial], fit: LinearFit, draw: Draw
) -> float:
    """Chance that a search through some trials surprises as much in residuals that are drawn."""
    null = largest_surprises(kin, fit, draw(fit, shop.settings.surrogates, shop.rng))
    return family_p_value(surprise, null)
