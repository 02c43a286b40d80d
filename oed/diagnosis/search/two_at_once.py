"""Two effects that one joint shows at once: a curve that does some of both outshines each alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.diagnosis.candidates.accepted import Accepted, Refused
from oed.diagnosis.candidates.open_shapes import decided
from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.search.several import several_at_once
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import inflation_of, none_explains_more, score
from oed.diagnosis.terms.trials import Trial

LEADERS = 3  # candidates for which a partner is looked for
REFINED = 3  # candidates for partners


def two_at_once(
    shop: Workshop,
    accepted: list[Accepted],
    pool: Sequence[Trial],
    joint: int,
    refused: list[Refused],
) -> list[Accepted]:
    """Two effects at a joint that together leave nothing to any free-form term nor to others, or none.

    Args:
        shop: The laid-out data.
        accepted: Additions so far.
        pool: Candidates, over the grids of their shapes.
        joint: Index.
        refused: Receives what falls at the last tests.
    """
    others = [a.trial for a in accepted]
    taken = {t.key for t in others}
    own = [t for t in pool if t.key not in taken and _is_of(t, joint, shop)]
    if len({t.key for t in own}) < 2:
        return []
    rows = shop.full.rows.count
    leaders = ranked(shop, own, others, LEADERS)
    pairs = [
        _with_partner(shop, own, others, leader.trial)
        for leader in leaders[:LEADERS]
        if leader.evidence(rows) > 0
    ]
    if not pairs:
        return []
    gains = np.array([_gain_together(shop, others, pair, joint) for pair in pairs])
    best = int(np.argmax(gains - [np.log(rows) * sum(t.freedom for t in pair) for pair in pairs]))
    if not _leaves_nothing(shop, others, joint, pairs[best]):
        return []
    pair = _decided(shop, others, pairs[best])
    if not _is_all(shop, [*others, *pair], joint):
        return []
    found = several_at_once(shop, accepted, pair, refused, are_all=True)
    return found if len(found) == len(pair) else []


def _is_of(trial: Trial, joint: int, shop: Workshop) -> bool:
    """Whether an effect is one of a joint, or a delay, and on the rows that all others are on."""
    if trial.between_repetitions and shop.full is not shop.mean:
        return False
    return trial.target is None if trial.fixed else trial.joint == joint


def _with_partner(
    shop: Workshop, own: Sequence[Trial], others: Sequence[Trial], leader: Trial
) -> list[Trial]:
    """A candidate and the best beside it, each refined beside the other."""
    rest = [t for t in own if t.key != leader.key]
    partner = ranked(shop, rest, [*others, leader], REFINED)[0].trial
    same = [t for t in own if t.key == leader.key]
    return [ranked(shop, same, [*others, partner], 1)[0].trial, partner]


def _gain_together(
    shop: Workshop, others: Sequence[Trial], added: Sequence[Trial], joint: int
) -> float:
    """Fall of a joint's white squares by some additions at once, beside others."""
    before, after = (
        shop.fit(chosen, shop.mean, bend=False).fit.residual[joint]
        for chosen in (others, [*others, *added])
    )
    return float(np.sum(before**2) - np.sum(after**2))


def _decided(shop: Workshop, others: Sequence[Trial], pair: Sequence[Trial]) -> list[Trial]:
    """Both, each as the validation recordings decide what is open of it beside the other."""
    kept = list(pair)
    for k, trial in enumerate(pair):
        beside = [*others, *(t for t in kept if t is not kept[k])]
        own = score(trial, shop.fit(beside, shop.layout(trial)).fit)
        kept[k] = decided(shop, beside, own).trial
    return kept


def _is_all(shop: Workshop, chosen: Sequence[Trial], joint: int) -> bool:
    """Whether additions bring a joint's error near its floor, on unseen recordings if there are.

    Where more is missing, two flexible effects find some of it to explain. In white rows, which know
    that rounding repeats with the motion, or in N m.
    """
    found, most = shop.fit(chosen, bend=False), shop.settings.floor_ratio
    rms = shop.validation_rms(found)
    if rms is None:
        return bool(inflation_of(shop.fit(chosen, shop.mean, bend=False).fit)[joint] < most**2)
    unseen = shop.unseen_by(chosen)
    white = np.sqrt(unseen.left(found) / unseen.counted)
    near = min(float(white[joint]), float(rms[joint] / shop.baseline.floor.deviation[joint]))
    return near < most


def _leaves_nothing(
    shop: Workshop, others: Sequence[Trial], joint: int, pair: Sequence[Trial]
) -> bool:
    """Whether no free-form term of one or two coordinates explains more, but for noise.

    At all joints: a curve at one has its say in the parameters that all share.
    """
    free = (
        t
        for t in (*shop.smooth, *shop.smooth_pairs)
        if t.joint == joint and not t.between_repetitions
    )
    before, after = (shop.fit(t, shop.mean).fit for t in (others, [*others, *pair]))
    return none_explains_more(free, before, before.squares - after.squares, [joint])
