"""Whether a candidate does more than to wipe up what an earlier addition left."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.tables.workbench import Layout
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import at_rest
from oed.diagnosis.terms.scores import Score, inflation_of, none_explains_more, score
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.smooth_term import FreeForm

STATIC = "position"  # family of torque at rest, which no lag that is a little wrong leaves
# Family of what scales torque: all joints have the links' parameters in common, so that a formula
# that gives one a little too much looks like a gain of another.
SCALE = "torque"
FAR_LESS = 1.25  # ratio of gains
COVERED = 0.3  # share of a gain that is left where another term explains the rest
# Share of an earlier effect's gain from which on an effect that looks like nothing else may be there.
MUCH_LESS = 0.002
ROUNDS = 3  # in which two effects settle beside one another


def too_little(
    shop: Workshop,
    candidate: Score,
    accepted: Sequence[Accepted],
    partners: Sequence[Trial] = (),
) -> str | None:
    """Why a candidate only wipes up what an earlier addition left; None if it does more.

    Args:
        shop: The laid-out data.
        candidate: Refined beside all others.
        accepted: Additions that it may only mend.
        partners: Others beside which it stands.
    """
    for earlier in accepted:
        meet = bool(set(earlier.trial.group) & set(candidate.trial.group))
        if not meet and SCALE not in _families(earlier) & _families(candidate):
            continue
        gained = (
            _gain_of_earlier(shop, accepted, earlier, candidate.trial) if meet else earlier.gain
        )
        share = candidate.gain / max(gained, 1e-300)
        if share >= shop.settings.mending_share:
            continue
        others = [a.trial for a in accepted]
        if (
            share < shop.settings.mop_up_floor
            and not (share >= MUCH_LESS and _like_nothing_else(shop, candidate, others))
            and _foretold_of_earlier(shop, candidate, earlier, others) < shop.settings.mop_up_floor
        ):
            return f"gains {share:.1%} of what {earlier.trial.name} gained"
        if not meet or _outdoes(shop, candidate, earlier, others):
            continue
        is_like = _may_be_one(earlier, candidate) and bool(
            _families(earlier) & _families(candidate)
        )
        is_slight = share < shop.settings.family_floor and is_like
        mend = None if is_slight else _mend_that_covers(shop, candidate, earlier, others)
        if not is_slight and mend is None:
            continue
        if _explain_more_together(shop, candidate, earlier, others):
            continue
        if mend is None:
            return f"gains {share:.1%} of what {earlier.trial.name}, its like, gained"
        return f"{mend} would mend the formula of {earlier.trial.name} as well"
    others = [*(a.trial for a in accepted), *partners]
    residual = shop.fit(others, shop.layout(candidate.trial)).fit.residual
    share = candidate.gain / float(np.sum(residual[list(candidate.trial.group)] ** 2))
    if share < shop.settings.least_share:
        return f"removes {share:.2%} of the residual's variance"
    return None


def _gain_of_earlier(
    shop: Workshop, accepted: Sequence[Accepted], earlier: Accepted, trial: Trial
) -> float:
    """What an earlier addition gains beside the others, at the joints on which a trial acts.

    No more than at its acceptance: others may have taken its place meanwhile.
    """
    if set(earlier.trial.group) <= set(trial.group):
        return earlier.gain
    others = [a.trial for a in accepted if a is not earlier]
    gain = gain_at(shop, list(trial.group), others, earlier.trial, shop.layout(trial))
    return min(earlier.gain, max(gain, 0.0))


def _foretold_of_earlier(
    shop: Workshop, candidate: Score, earlier: Accepted, others: Sequence[Trial]
) -> float:
    """What a candidate foretells of unseen recordings, as a share of what an earlier addition does.

    They may move where those that it was fitted to do not, as slowly as it needs.
    """
    rest = [t for t in others if t.key != earlier.trial.key]
    whole, joints = [*others, candidate.trial], list(candidate.trial.group)
    unseen, layout = shop.unseen_by(whole), shop.layout_for(whole)
    bare, without, within = (
        float(unseen.left(shop.fit(chosen, layout, bend=False))[joints].sum())
        for chosen in (rest, others, whole)
    )
    if without - within < shop.settings.decisive * max(1.0, within / unseen.counted[joints].sum()):
        return 0.0
    return (without - within) / max(bare - without, 1e-300)


def gain_at(
    shop: Workshop,
    joints: list[int],
    others: Sequence[Trial],
    trial: Trial,
    layout: Layout,
) -> float:
    """Fall of the white squares of some joints by an addition, beside others."""
    before, after = (
        float(np.sum(shop.fit(chosen, layout).fit.residual[joints] ** 2))
        for chosen in (others, [*others, trial])
    )
    return before - after


def _like_nothing_else(shop: Workshop, candidate: Score, others: Sequence[Trial]) -> bool:
    """Whether no curve of any coordinates explains as much as an effect of few parameters does.

    What a wrong formula leaves, or smoothing, looks like a curve sooner than like another effect.
    """
    if candidate.trial.is_free_form or shop.layout(candidate.trial) is not shop.mean:
        return False
    fit = shop.fit(others, shop.mean).fit
    joints = list(candidate.trial.group)
    margin = shop.settings.free_form_margin * float(inflation_of(fit)[joints].mean())
    free = [t for t in shop.smooth if t.joint in joints and not t.between_repetitions]
    return candidate.evidence(shop.full.rows.count) > margin and none_explains_more(
        free, fit, candidate.gain, joints
    )


def _outdoes(shop: Workshop, candidate: Score, earlier: Accepted, others: Sequence[Trial]) -> bool:
    """Whether an effect with none but a size to adapt explains all that a curve could beside another.

    A wrong formula leaves what a function of the coordinates explains best, its own or those of
    what would mend it. One of the same family with a shape might adapt to the other meanwhile.
    """
    own = candidate.trial
    if own.is_free_form or earlier.trial.is_free_form:
        return False
    if earlier.trial.fixed and STATIC not in _families(candidate):
        return False
    if own.shapes > own.fixed:  # a size in a shape of its own, as of a delay, adapts to nothing
        return False
    if earlier.trial.shapes and _families(earlier) & _families(candidate):
        return False
    free = [m for t in (own, earlier.trial) for m in _free_forms_of(shop, t)]
    fit = shop.fit(others, shop.mean).fit
    return bool(free) and none_explains_more(free, fit, candidate.gain, list(own.group))


def _mend_that_covers(
    shop: Workshop, candidate: Score, earlier: Accepted, others: Sequence[Trial]
) -> str | None:
    """A free-form term of an earlier effect's own coordinates that covers a candidate.

    None does that explains less by far, though it has more parameters.
    """
    layout = shop.layout(candidate.trial)
    mends = [] if candidate.trial.is_free_form else _free_forms_of(shop, earlier.trial)
    for mend in mends:
        fit = shop.fit([*others, mend], layout).fit
        left = score(candidate.trial, fit).gain
        own = score(mend, shop.fit(others, shop.layout(mend)).fit).gain
        if left < COVERED * candidate.gain < COVERED * FAR_LESS * own:
            return str(mend.key[0])
    return None


def _explain_more_together(
    shop: Workshop, candidate: Score, earlier: Accepted, others: Sequence[Trial]
) -> bool:
    """Whether two effects, each at its best beside the other, explain more than any mend does.

    The earlier one was fitted to what both do: what that shape leaves is no measure of either.
    Free-form terms of all its own coordinates are held against the two, parameters counted.
    """
    pair, layout = [earlier.trial, candidate.trial], shop.layout(candidate.trial)
    if candidate.trial.is_free_form or layout is not shop.mean:
        return False
    rest = [t for t in others if t.key != earlier.trial.key]
    for _ in range(ROUNDS):
        for k, trial in enumerate(pair):
            beside = shop.fit([*rest, pair[1 - k]], layout).fit
            pair[k] = at_rest(score(shop.renewed(trial), beside), beside, shop.context).trial
    both = shop.fit([*rest, *pair], layout, bend=False).fit
    chance = float(inflation_of(both)[list(candidate.trial.group)].mean())
    price = chance * np.log(layout.rows.count)

    def cost(fit: LinearFit, shapes: int) -> float:
        return fit.squares + price * (fit.projection.rank + shapes)

    own = cost(both, sum(t.shapes for t in pair))
    mends = _free_forms_of(shop, earlier.trial)
    return bool(mends) and all(
        own + chance * shop.settings.decisive
        < cost(shop.fit([*others, mend], layout, bend=False).fit, earlier.trial.shapes)
        for mend in mends
    )


def _free_forms_of(shop: Workshop, named: Trial) -> list[Trial]:
    """Free-form terms at a named effect's joint of nothing but its coordinates."""
    return [
        t
        for t in shop.smooth
        if t.joint == named.joint and not t.between_repetitions and is_own(t, named)
    ]


def is_own(free: Trial, named: Trial) -> bool:
    """Whether a free-form term is but a freer form of a named effect.

    None of the catalogue's effects is a signal whose coefficient varies with position, and what
    stays the same mends nothing that changes in time.
    """
    effect = free.effect
    if not isinstance(effect, FreeForm) or effect.varies or named.is_free_form:
        return False
    if free.between_repetitions != named.between_repetitions:
        return False
    return set(effect.depends_on) <= set(named.effect.depends_on)


def _may_be_one(earlier: Accepted, candidate: Score) -> bool:
    """Whether two of a family act in one place; another joint's gear has its own equation."""
    places = {earlier.trial.joint, candidate.trial.joint}
    return len(places) == 1 or None in places


def _families(item: Accepted | Score) -> set[str]:
    return set() if item.trial.is_free_form else set(CATALOGUE[item.trial.name].families)
