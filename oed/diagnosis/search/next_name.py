"""The name that comes next."""

from __future__ import annotations

from collections.abc import Sequence

from oed.diagnosis.candidates.accepted import Accepted, Refused, refusal
from oed.diagnosis.candidates.judgement import judge
from oed.diagnosis.candidates.pickups import with_own_moments
from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.candidates.telling import most_telling_first
from oed.diagnosis.search.free_form_rivals import better_free_form, curves_explain_more
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial


def next_names(
    shop: Workshop,
    accepted: list[Accepted],
    refused: list[Refused],
    pool: Sequence[Trial],
    most: int = 1,
) -> list[Accepted]:
    """The first of the leading names that pass all tests beside what was accepted.

    Args:
        shop: The laid-out data; takes up the moments of a load that is accepted.
        accepted: Additions so far.
        refused: Takes in what is turned down.
        pool: Candidates, over the grids of their shapes.
        most: How many; those after the first are of joints on which none before them acts, and
            pass beside these.
    """
    picks: list[Accepted] = []
    others = [a.trial for a in accepted]
    rows = shop.full.rows.count
    found = ranked(shop, pool, others, shop.settings.refined, thorough=True)
    found = [c for c in found if c.evidence(rows) > 0]
    # At a shape that the validation recordings decide, one may explain nothing of the others.
    telling = most_telling_first(shop, found, others)
    candidates = [c for c in telling if c.evidence(rows) > 0]
    rivals = ranked(shop, shop.smooth, others, shop.settings.refined)
    for candidate in candidates:
        if any(_meet(candidate.trial, pick.trial) for pick in picks):
            continue
        better = better_free_form(shop, candidate, rivals, others)
        if better is not None:
            times = better.gain / candidate.gain
            reason = f"{better.trial.key[0]} explains {times:.2g} times as much"
        else:
            reason = curves_explain_more(shop, candidate, others)
        if reason is not None:
            refused.append(refusal(candidate, reason))
            continue
        own = with_own_moments(shop, others, candidate)
        passed = judge(shop, own, [*accepted, *picks], shop.physical, refused)
        if passed is not None:
            picks.append(passed)
            if len(picks) == most or passed.trial.joint is None:
                break
        elif own is not candidate:
            shop.take_up(())
    return picks


def _meet(one: Trial, other: Trial) -> bool:
    """Whether two additions act on a joint in common, or one on the whole arm."""
    return None in (one.joint, other.joint) or not set(one.group).isdisjoint(other.group)
