"""One effect in several joints at once: what all joints share may hide it in each alone.

Every joint of an arm has a rotor, and every torque signal its offset. Fitted in one joint only, the
link parameters that rows share take the blame for the others, and the held-out error rises there.
So a kind is tried in all joints together, and those that do not need it beside the rest fall away.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.accepted import Accepted, Refused
from oed.diagnosis.candidates.judgement import costs, judge, rise
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import Score, implausible, inflation_of, score
from oed.diagnosis.terms.trials import Trial

LEAST = 2  # joints


def several_at_once(
    shop: Workshop,
    accepted: list[Accepted],
    kind: Sequence[Trial],
    refused: list[Refused],
    *,
    are_all: bool = False,
) -> list[Accepted]:
    """Joints that need an effect beside one another, with the evidence of each; none if below two.

    Args:
        shop: The laid-out data.
        accepted: Additions so far.
        kind: One effect without shapes, in every joint that does not have it yet.
        refused: Receives the joints that fell at the last tests, where others stay.
        are_all: Whether nothing is left beside them, so that none is to mend another's formula.
    """
    others, fallen = [a.trial for a in accepted], []
    members = _foretelling(shop, others, _needed(shop, others, kind))
    while len(members) >= LEAST:
        scores = _beside_one_another(shop, others, members)
        judged = []
        for s in scores:
            known = accepted if are_all else [*accepted, *_unjudged(scores, but=s)]
            partners = [m for m in members if m is not s.trial] if are_all else []
            judged.append(judge(shop, s, known, shop.physical, fallen, partners=partners))
        kept = [found for found in judged if found is not None]
        if len(kept) == len(members):
            refused += fallen
            return kept
        members = _foretelling(shop, others, [found.trial for found in kept])
    return []


def _beside_one_another(
    shop: Workshop, others: Sequence[Trial], members: Sequence[Trial]
) -> list[Score]:
    """What each gains beside additions and the other members."""
    scores = []
    for member in members:
        rest = [m for m in members if m is not member]
        fit = shop.fit([*others, *rest], shop.layout(member), bend=False).fit
        scores.append(score(member, fit))
    return scores


def _needed(shop: Workshop, others: Sequence[Trial], kind: Sequence[Trial]) -> list[Trial]:
    """Members that are plausible and explain more than their parameters must."""
    members = list(kind)
    while members:
        whole = shop.fit([*others, *members], shop.layout(members[0]), bend=False).fit
        scores = _beside_one_another(shop, others, members)
        worths = [_worth(shop, s, inflation_of(whole)) for s in scores]
        if min(worths) > 0:
            break
        members.pop(int(np.argmin(worths)))
    return members


def _worth(shop: Workshop, member: Score, chance: Float[ndarray, " joints"]) -> float:
    """Gain in units of the misfit less Schwarz's penalty."""
    if implausible(member, shop.context) is not None:
        return -np.inf
    unit = float(chance[list(member.trial.group)].mean())
    return member.gain / unit - member.freedom * float(np.log(shop.full.rows.count))


def _foretelling(shop: Workshop, others: Sequence[Trial], members: Sequence[Trial]) -> list[Trial]:
    """Members that together lower the held-out error; those that raise it most fall away."""
    floor, counted = shop.baseline.floor.deviation, shop.unseen_full.counted
    kept, old = list(members), _held_out(shop, others)
    if old is None:
        return kept

    def risen(rest: Sequence[Trial]) -> float:
        new = _held_out(shop, [*others, *rest])
        return 0.0 if new is None else rise(old, new, counted)

    while kept:
        new = _held_out(shop, [*others, *kept])
        if new is None or not costs(old, new, floor, counted):
            break
        without = [[m for m in kept if m is not left_out] for left_out in kept]
        kept = min(without, key=risen)
    return kept


def _held_out(shop: Workshop, chosen: Sequence[Trial]) -> Float[ndarray, " joints"] | None:
    """Validation error of each joint [N m]; None without validation recordings."""
    return shop.validation_rms(shop.fit(chosen, bend=False))


def _unjudged(scores: Sequence[Score], *, but: Score) -> list[Accepted]:
    return [Accepted(s.trial, s.gain) for s in scores if s is not but]
