"""How likely chance alone is to explain as much as a candidate, over a whole search."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.surrogates import (
    NullSearch,
    family_p_value,
    flipped,
    moved_in_time,
    undiminished,
)
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import Score, inflation_of
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.diagnosis_new.rows.weighted_rows import Rows

MAIN = 0.1  # of the most that a candidate explains of a joint, at one that counts
ROUNDS = 10  # of residuals at most, while a chance is within
DOUBTFUL = 5.0  # times the level, or of it

# What chance might have left instead of some noise on rows, so many times.
Draw = Callable[
    [Float[ndarray, "joints rows"], Rows, int, np.random.Generator],
    Float[ndarray, "joints rows count"],
]


def p_value_of(
    shop: Workshop, candidate: Score, others: Sequence[Trial], pool: Sequence[Trial]
) -> float:
    """Family-wise p-value; chance is what the model with the candidate leaves of its joints."""
    before, after = _without_and_with(shop, candidate, others)
    return _family_wise(shop, _at_home(candidate, before, after), after, flipped, pool)


def chance_of_slow_noise(
    shop: Workshop, candidate: Score, others: Sequence[Trial], pool: Sequence[Trial]
) -> float:
    """Family-wise p-value of noise so slow that a curve of the arm's state can follow it.

    What a term has taken for the arm's doing is gone from what it leaves. So chance is what was
    there before, moved in time: noise keeps no step with the arm, and a search finds as much in it.
    """
    before, after = _without_and_with(shop, candidate, others)
    return _family_wise(shop, _at_home(candidate, before, after), before, moved_in_time, pool)


def _without_and_with(
    shop: Workshop, candidate: Score, others: Sequence[Trial]
) -> tuple[LinearFit, LinearFit]:
    layout = shop.layout(candidate.trial)
    before, after = (shop.fit(t, layout).fit for t in (others, [*others, candidate.trial]))
    return before, after


def _at_home(candidate: Score, before: LinearFit, after: LinearFit) -> Score:
    """A candidate in the joints of which it explains something.

    What others lack, where it hardly acts, says nothing of chance.
    """
    falls = np.sum(before.residual**2, axis=1) - np.sum(after.residual**2, axis=1)
    group = candidate.trial.group
    most = max(float(falls[joint]) for joint in group)
    main = {j: block for j, block in group.items() if falls[j] >= MAIN * most}
    if len(main) == len(group) or most <= 0:
        return candidate
    gain = float(sum(falls[j] for j in main))
    trial = dataclasses.replace(candidate.trial, group=main)
    return dataclasses.replace(candidate, trial=trial, gain=gain)


def keeps_step(shop: Workshop, others: Sequence[Trial], joint: int) -> bool:
    """Whether what additions leave of a joint keeps step with the arm; slow noise may not.

    Always where repetitions show what noise is.
    """
    if shop.mean is not shop.full:
        return True
    fit = shop.fit(others, shop.mean).fit
    own = [t for t in (*shop.smooth, *shop.smooth_pairs) if t.joint == joint]
    search = NullSearch.beside(fit, own)
    left = float(search.largest_surprises(fit.residual[:, :, None])[0])
    level, null = shop.settings.level, _null(shop, search, moved_in_time)
    return chance_of(left, null, level, float(shop.context.n)) <= level


def keeps_step_unseen(shop: Workshop, others: Sequence[Trial], joint: int) -> bool:
    """Whether the validation recordings, fitted by themselves, leave what keeps step with the arm.

    What is missing may show in their motion alone.
    """
    if not shop.validation:
        return False
    own = shop.validation
    alone = Workshop(shop.baseline, own, (), shop.settings, drives=shop.drives)
    return keeps_step(alone, [alone.renewed(t) for t in others], joint)


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
        dataclasses.replace(t, group={j: b for j, b in t.group.items() if j in own.group})
        for t in pool
        if t.between_repetitions == own.between_repetitions
        and not set(t.group).isdisjoint(own.group)
    ]
    surprise = candidate.surprise(inflation_of(fit))
    places = shop.context.n / len(own.group)
    null = _null(shop, NullSearch.beside(fit, kin), draw)
    return chance_of(surprise, null, shop.settings.level, places)


def _null(shop: Workshop, search: NullSearch, draw: Draw) -> Callable[[], Float[ndarray, " count"]]:
    """Surprises of a search, in as many residuals as are drawn at once."""
    noise, rows, count = undiminished(search.fit), search.fit.rows, shop.settings.surrogates
    # Of its own, so that what was asked before, or by another process, does not change the answer.
    rng = np.random.default_rng(shop.settings.seed)
    return lambda: search.largest_surprises(draw(noise, rows, count, rng))


def chance_of(
    surprise: float, null: Callable[[], Float[ndarray, " count"]], level: float, places: float
) -> float:
    """Chance that a search in so many places surprises as much.

    Near the level, which a few residuals that are drawn put it above or below, more are.
    """
    found, chance = np.zeros(0), 1.0
    for _ in range(ROUNDS):
        found = np.append(found, null())
        chance = min(1.0, places * family_p_value(surprise, found))
        if abs(np.log(chance / level)) > np.log(DOUBTFUL):
            break
    return chance
