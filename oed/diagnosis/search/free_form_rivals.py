"""Names held against free-form terms: what a curve does better by far is not what they say."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from oed.diagnosis.candidates.judgement import share_needed
from oed.diagnosis.candidates.leftovers import COVERED
from oed.diagnosis.candidates.telling import foretells_most
from oed.diagnosis.tables.workbench import Layout
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.restraint import restrained
from oed.diagnosis.terms.scores import Score, inflation_of, score
from oed.diagnosis.terms.trials import Trial, white_group
from oed.dynamics.effects.catalogue import CATALOGUE

# Share of what a free form, or a name and it together, explain that the name in more terms must
# reach: four waves hold 95 % of a sawtooth, and 55 to 85 % of a bump that comes once.
FULLER = 0.9
WORTH = 0.2  # share of what a free form explains, from which on a name is tried in more terms


def better_free_form(
    shop: Workshop, candidate: Score, rivals: list[Score], others: Sequence[Trial]
) -> Score | None:
    """A free-form term that is better by far, and leaves little for the candidate to explain."""
    rows = shop.full.rows.count
    for rival in rivals:
        if rival.evidence(rows) - candidate.evidence(rows) < shop.settings.free_form_margin:
            break
        share = share_needed([rival.trial], candidate.trial, shop.settings)
        if candidate.gain > share * rival.gain:
            continue
        if rival.trial.joint == candidate.trial.joint and candidate.gain > WORTH * rival.gain:
            fuller = in_more_terms(shop, candidate.trial, others, shop.layout(rival.trial))
            if fuller is not None and fuller.gain > FULLER * rival.gain:
                continue
        if _are_apart(candidate.trial, rival.trial) and not _covered(
            shop, candidate, rival, others
        ):
            continue
        fit = shop.fit(others, shop.layout(rival.trial)).fit
        if not foretells_most(shop, others, candidate.trial, restrained(rival.trial, fit)):
            return rival
    return None


def curves_explain_more(shop: Workshop, candidate: Score, others: Sequence[Trial]) -> str | None:
    """Why a change of the whole arm is none: a curve for each joint explains more; None if not.

    Ten parameters from a moment on explain something of whatever joints lack on one motion. Where
    motions repeat, what differs between them is known, and no curve explains that.

    Args:
        shop: The laid-out data.
        candidate: Refined beside all others.
        others: Additions that it stands beside.
    """
    trial = candidate.trial
    repeats = shop.full is not shop.mean
    if trial.joint is not None or repeats or not trial.between_repetitions:
        return None
    fit = shop.fit(others, shop.mean).fit
    noise = inflation_of(fit)
    most = np.zeros(len(noise))
    for term in shop.smooth:
        if term.joint is not None and not term.between_repetitions:
            found = score(term, fit)
            net = found.gain - found.freedom * noise[term.joint]
            most[term.joint] = max(most[term.joint], net)
    ratio = float(most.sum()) / candidate.gain
    return f"curves of the joints explain {ratio:.2g} times as much" if ratio > 1 else None


def in_more_terms(
    shop: Workshop, trial: Trial, others: Sequence[Trial], layout: Layout
) -> Score | None:
    """A named effect in more terms, those that explain most beside others; None if it has none."""
    build = CATALOGUE[trial.name].fuller
    if build is None:
        return None
    fit = shop.fit(others, layout).fit
    bare = dataclasses.replace(trial, values=())
    effects = build(shop.context, trial.target, trial.values)
    tried = (
        score(dataclasses.replace(bare, effect=e, group=white_group(e, layout.rows)), fit)
        for e in effects
    )
    return max(tried, key=lambda s: s.gain)


def _are_apart(one: Trial, other: Trial) -> bool:
    """Whether two additions act on other joints, or one on what differs between repetitions alone."""
    return one.joint != other.joint or one.between_repetitions != other.between_repetitions


def _covered(shop: Workshop, candidate: Score, rival: Score, others: Sequence[Trial]) -> bool:
    """Whether most of a candidate's gain is gone beside a term of other rows."""
    layout = shop.layout(candidate.trial)
    fit = shop.fit([*others, rival.trial], layout).fit
    return score(candidate.trial, fit).gain < COVERED * candidate.gain
