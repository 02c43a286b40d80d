"""Rivals compared by what they explain and by what they foretell.

What a model lacks besides is no chance: on one motion a flexible effect takes up some of it, and
its evidence grows. So rivals are compared on the estimation and the validation recordings
together (the likelihood of both is that of the first times that of the second, foretold from the
first), and squares count in units of what the best of them leaves (quasi-likelihood; Burnham and
Anderson 2002, Model Selection and Multimodel Inference, section 2.5).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.calming import calmed_beside, worth_beside
from oed.diagnosis.candidates.margin import is_first_order, tied_within
from oed.diagnosis.candidates.open_shapes import decided
from oed.diagnosis.candidates.ripening import is_part_of
from oed.diagnosis.candidates.turning import GRAVITY
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import Score, inflation_of
from oed.diagnosis.terms.trials import Trial
from oed.parallel_map import side_by_side

RIVAL_SHARE = 0.7  # of the best gain, from which on another candidate may be the one that is meant
FAR_MORE = 1.5  # ratio of gains
# Shares of the validation squares beyond noise. Where no free-form term foretells anything, an
# effect need not do most of it: more than one thing may be missing.
MOST = 0.5
MUCH = 0.2


def telling(
    shop: Workshop, others: Sequence[Trial], rivals: Sequence[Score]
) -> tuple[Float[ndarray, " rivals"], float]:
    """How much each of some rivals says: -2 log likelihood of all rows, less what it costs.

    Args:
        shop: The laid-out data.
        others: Additions that they stand beside.
        rivals: Refined candidates for one place.

    Returns:
        That, and the unit in which it counts what explains the estimation recordings.
    """
    acting = sorted({joint for rival in rivals for joint in rival.trial.group})
    left, foretold, errors = [], [], []
    for rival in rivals:
        whole = [*others, rival.trial]
        unseen, layout = shop.unseen_by(whole), shop.layout_for(whole)
        before, after = (
            unseen.left(shop.fit(chosen, layout, bend=False)) for chosen in (others, whole)
        )
        quieter = calmed_beside(others, rival.trial, unseen.rows) if unseen.rows else 0.0
        foretold.append(before - after - quieter)
        errors.append(after / unseen.counted)
        found = shop.fit(whole, shop.layout(rival.trial), bend=False)
        left.append(float(inflation_of(found.fit)[acting].mean()))
    unit = np.maximum(np.min(errors, axis=0), 1.0)
    rows = shop.full.rows.count
    worth = worth_beside(others, shop.mean.rows)
    explained = np.array([worth(r) for r in rivals]) / min(left)
    costs = np.array([r.price(rows) for r in rivals])
    return explained - costs + np.array(foretold) @ (1 / unit), min(left)


def most_telling_first(
    shop: Workshop, candidates: Sequence[Score], others: Sequence[Trial]
) -> list[Score]:
    """Those that explain about as much as the best one, by what they tell; then the rest.

    Where that does not decide, the plainest comes first: the first order of another, else the
    one that cancels least against the model.

    Args:
        shop: The laid-out data.
        candidates: Refined, best evidence first.
        others: Additions that they stand beside.
    """
    if not candidates or candidates[0].gain <= 0:
        return list(candidates)
    best = candidates[0]
    level = [
        c
        for c in candidates
        if c.gain > RIVAL_SHARE * best.gain and not set(c.trial.group).isdisjoint(best.trial.group)
    ]
    rest = [c for c in candidates if all(c is not r for r in level)]
    level = side_by_side(lambda c: decided(shop, others, c), level)
    values, unit = telling(shop, others, level)
    first = level[int(np.argmax(values))]
    tied = [
        values.max() - value < tied_within(shop, first, c, unit)
        for value, c in zip(values, level, strict=True)
    ]
    order = sorted(
        range(len(level)),
        key=lambda i: (not tied[i], *(_plainness(level[i], first) if tied[i] else (-values[i],))),
    )
    return [*(level[i] for i in order), *rest]


def may_replace(shop: Workshop, here: Score, rival: Score) -> bool:
    """Whether the evidence leaves it open that a rival replaces an addition.

    Of one kind the less plain one must explain far more: where other things are missing besides,
    its further parameters find some of them to explain.
    """
    if _is_plainer(here, rival) and rival.gain < FAR_MORE * here.gain:
        return False
    rows = shop.full.rows.count
    lead = rival.evidence(rows) - here.evidence(rows)
    return lead > shop.settings.decisive or _is_plainer(rival, here)


def replaces(shop: Workshop, others: Sequence[Trial], here: Score, rival: Score) -> bool:
    """Whether a rival tells more by far than an addition, or as much and is plainer."""
    both = [decided(shop, others, s) for s in (here, rival)]
    (said, better), unit = telling(shop, others, both)
    margin = tied_within(shop, here, rival, unit, close=shop.settings.decisive)
    return bool(better > said + (-margin if _is_plainer(rival, here) else margin))


def _is_plainer(one: Score, other: Score) -> bool:
    """Whether one is the other's first order, or the gear in it."""
    return is_first_order(one.trial, other.trial) and _freedom(one, other) < other.freedom


def _freedom(one: Score, other: Score) -> int:
    """Parameters of one beside another: a gear that is part of it has fewer in any case."""
    if is_part_of(one.trial, other.trial):
        return min(one.freedom, other.freedom - 1)
    if is_part_of(other.trial, one.trial):
        return max(one.freedom, other.freedom + 1)
    return one.freedom


def _plainness(tied: Score, first: Score) -> tuple[float, ...]:
    """Of two of one kind the one with fewer parameters; else what cancels least."""
    nested = is_first_order(tied.trial, first.trial)
    return (float(_freedom(tied, first) if nested else first.freedom), tied.cancelled)


def _foretold_share(
    shop: Workshop, others: Sequence[Trial], added: Trial, joints: list[int]
) -> float:
    """Share of the validation squares beyond noise that an addition removes from some joints."""
    whole = [*others, added]
    layout, unseen = shop.layout_for(whole), shop.unseen_by(whole)
    after = unseen.left(shop.fit(whole, layout, bend=False))[joints].sum()
    if added.name == GRAVITY and shop.is_turned:  # the tables have most of it already
        level = shop.upright
        rest = [level.renewed(t) for t in others]
        fit = level.fit(rest, level.layout_for(rest), bend=False)
        before = level.unseen_by(rest).left(fit)[joints].sum()
    else:
        before = unseen.left(shop.fit(others, layout, bend=False))[joints].sum()
    excess = before - unseen.counted[joints].sum()
    return float((before - after) / excess) if excess > 0 else 0.0


def foretells_most(
    shop: Workshop, others: Sequence[Trial], named: Trial, free: Iterable[Trial]
) -> bool:
    """Whether an effect foretells most of what its joints do, and no free-form term more.

    Without such a term, much of it will do.

    A free-form term explains more of the motion that it was fitted to than any physics does,
    where more than one thing is missing. What holds on another motion is no chance.

    Args:
        shop: The laid-out data.
        others: Additions beside which both stand.
        named: An effect of the catalogue.
        free: Terms that have its place to themselves, one at a time, as far as the data
            determine them.
    """
    joints, free = sorted(named.group), list(free)
    share = _foretold_share(shop, others, named, joints)
    if share < (MOST if free else MUCH):
        return False
    return all(share >= _foretold_share(shop, others, term, joints) for term in free)
