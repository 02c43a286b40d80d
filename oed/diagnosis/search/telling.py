"""Rivals compared by what they explain and by what they foretell.

What a model lacks besides is no chance: on one motion a flexible effect takes up some of it, and
its evidence grows. So rivals are compared on the estimation and the validation recordings
together (the likelihood of both is that of the first times that of the second, foretold from the
first), and squares count in units of what the best of them leaves (quasi-likelihood; Burnham and
Anderson 2002, Model Selection and Multimodel Inference, section 2.5).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.search.scan import Score, inflation_of
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.terms.trials import Trial

RIVAL_SHARE = 0.7  # of the best gain, from which on another candidate may be the one that is meant
MOST = 0.5  # share of the validation squares beyond noise


def telling(
    shop: Workshop, others: Sequence[Trial], rivals: Sequence[Score]
) -> Float[ndarray, " rivals"]:
    """How much each of some rivals says: -2 log likelihood of all rows, less what it costs.

    Args:
        shop: The laid-out data.
        others: Additions that they stand beside.
        rivals: Refined candidates for one place.
    """
    acting = sorted({joint for rival in rivals for joint in rival.trial.group})
    left, foretold, errors = [], [], []
    for rival in rivals:
        layout = shop.layout(rival.trial)
        unseen = shop.unseen_by([*others, rival.trial])
        before = unseen.left(shop.fit(others, layout, bend=False))
        found = shop.fit([*others, rival.trial], layout, bend=False)
        after = unseen.left(found)
        foretold.append(before - after)
        errors.append(after / unseen.counted)
        left.append(float(inflation_of(found.fit)[acting].mean()))
    unit = np.maximum(np.min(errors, axis=0), 1.0)
    rows = shop.full.rows.count
    explained = np.array([r.gain for r in rivals]) / min(left)
    costs = np.array([r.gain - r.evidence(rows) for r in rivals])
    return explained - costs + np.array(foretold) @ (1 / unit)


def most_telling_first(
    shop: Workshop, candidates: Sequence[Score], others: Sequence[Trial]
) -> list[Score]:
    """Those that explain about as much as the best one, by what they tell; then the rest.

    Where that does not decide, the one that cancels least against the model comes first.

    Args:
        shop: The laid-out data.
        candidates: Refined, best evidence first.
        others: Additions that they stand beside.
    """
    if not candidates:
        return []
    best = candidates[0]
    level = [
        c
        for c in candidates
        if c.gain > RIVAL_SHARE * best.gain and not set(c.trial.group).isdisjoint(best.trial.group)
    ]
    rest = [c for c in candidates if all(c is not r for r in level)]
    values = telling(shop, others, level)
    tied = values.max() - values < shop.settings.decisive
    order = sorted(
        range(len(level)),
        key=lambda i: (not tied[i], level[i].cancelled if tied[i] else -values[i]),
    )
    return [*(level[i] for i in order), *rest]


def foretold_share(
    shop: Workshop, others: Sequence[Trial], added: Sequence[Trial], joints: Sequence[int]
) -> float:
    """Share of the validation squares beyond noise that additions remove from some joints."""
    layout = shop.layout_for([*others, *added])
    unseen = shop.unseen_by([*others, *added])
    before, after = (
        unseen.left(shop.fit(chosen, layout, bend=False))[list(joints)].sum()
        for chosen in (others, [*others, *added])
    )
    excess = before - unseen.counted[list(joints)].sum()
    return float((before - after) / excess) if excess > 0 else 0.0


def foretells_most(
    shop: Workshop, others: Sequence[Trial], named: Trial, free: Sequence[Trial]
) -> bool:
    """Whether an effect foretells most of what its joints do, and free-form terms no more.

    A free-form term explains more of the motion that it was fitted to than any physics does,
    where more than one thing is missing. What holds on another motion is no chance.

    Args:
        shop: The laid-out data.
        others: Additions beside which both stand.
        named: An effect of the catalogue.
        free: Terms in its place, as far as they stand in.
    """
    joints = sorted(named.group)
    share = foretold_share(shop, others, [named], joints)
    if share < MOST:
        return False
    return not free or share >= foretold_share(shop, others, free, joints)
