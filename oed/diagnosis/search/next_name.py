"""The name that comes next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from oed.diagnosis.candidates.accepted import Accepted, Refused, refusal
from oed.diagnosis.candidates.judgement import judge
from oed.diagnosis.candidates.pickups import is_load, with_own_moments
from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.candidates.telling import most_telling_first
from oed.diagnosis.search.free_form_rivals import better_free_form, curves_explain_more
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import Score
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.effects.payload import PickUp
from oed.parallel_map import one_by_one


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
    left = candidates
    while left and len(picks) < most:
        test = partial(_tested, shop, [*accepted, *picks], others, rivals)
        done, passed = 0, None
        for tested in one_by_one(test, left):
            done, passed = done + 1, tested.passed
            refused += tested.refused
            if tested.moments is not None:
                shop.take_up(tested.moments)
            if passed is not None:
                picks.append(passed)
                break
        if passed is None or passed.trial.joint is None:
            break
        left = [c for c in left[done:] if not _meet(c.trial, passed.trial)]
    return picks


@dataclass(frozen=True)
class _Tested:
    """A candidate after all tests.

    Attributes:
        passed: It as an addition; None if it failed.
        refused: What was turned down.
        moments: Of a load, which the tables are to have; none if it failed, None of others.
    """

    passed: Accepted | None
    refused: list[Refused]
    moments: tuple[PickUp, ...] | None = None


def _tested(
    shop: Workshop,
    accepted: list[Accepted],
    others: Sequence[Trial],
    rivals: list[Score],
    candidate: Score,
) -> _Tested:
    """A candidate held against free-form terms and put to all tests; the tables stay as they are.

    Args:
        shop: The laid-out data.
        accepted: Additions beside which it must pass.
        others: Additions beside which it was found.
        rivals: Free-form terms, best evidence first.
        candidate: Refined beside the others.
    """
    better = better_free_form(shop, candidate, rivals, others)
    if better is not None:
        times = better.gain / candidate.gain
        reason = f"{better.trial.key[0]} explains {times:.2g} times as much"
    else:
        reason = curves_explain_more(shop, candidate, others)
    if reason is not None:
        return _Tested(None, [refusal(candidate, reason)])
    refused: list[Refused] = []
    with shop.for_a_while():
        own = with_own_moments(shop, others, candidate)
        passed = judge(shop, own, accepted, shop.physical, refused)
        moments = shop.pickups if passed is not None else ()
    return _Tested(passed, refused, moments if is_load(candidate.trial) else None)


def _meet(one: Trial, other: Trial) -> bool:
    """Whether two additions act on a joint in common, or one on the whole arm."""
    return None in (one.joint, other.joint) or not set(one.group).isdisjoint(other.group)
