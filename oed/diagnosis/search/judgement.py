"""Whether one candidate may be added: plausible, significant, and paying on what it has not seen."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.search.chance import p_value_of
from oed.diagnosis.search.held_out import cross_validate
from oed.diagnosis.search.scan import Score, implausible, inflation_of, none_explains_more, score
from oed.diagnosis.search.within import comes_at_once, differs_alone
from oed.diagnosis.search.workbench import Layout
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.terms.free_form import FreeForm
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.effects.catalogue import CATALOGUE

STATIC = "position"  # family of torque at rest, which no lag that is a little wrong leaves
FAR_LESS = 1.25  # ratio of gains
COVERED = 0.3  # share of a gain that is left where another term explains the rest
# Share of an earlier effect's gain from which on an effect that looks like nothing else may be there.
MUCH_LESS = 0.002
WORSE = 1.02  # ratio up to which a joint's held-out error may rise while the sum falls
# Share of what joints win, in -2 log likelihood, that others may lose to a named effect: it moves
# parameters that all rows share, and so does a share of another joint's torque. To a curve
# that claims no physics nobody has to lose.
PRICE = 1 / 3


@dataclass(frozen=True)
class Accepted:
    """An addition with the evidence at the time it was accepted.

    Attributes:
        trial: The addition.
        gain: Fall of the white sum of squares.
        p_value: Family-wise, over the whole search.
        stands_in: Whether it is part of the model. A free-form term that does not predict
            what it was not fitted to only says where something is missing.
    """

    trial: Trial
    gain: float
    p_value: float
    stands_in: bool = True


@dataclass(frozen=True)
class Refused:
    """A candidate that looked good and was turned down.

    Attributes:
        name: Of the catalogue, or the free-form term's label.
        joint: Index, None for the whole arm.
        gain: Fall of the white sum of squares that it promised.
        reason: Why it was turned down.
    """

    name: str
    joint: int | None
    gain: float
    reason: str


def judge(
    shop: Workshop,
    candidate: Score,
    accepted: list[Accepted],
    pool: Sequence[Trial],
    refused: list[Refused],
) -> Accepted | None:
    """All tests in the order of their cost; the first that fails is the reason given."""
    others = [a.trial for a in accepted]
    reason = too_little(shop, candidate, accepted) or implausible(candidate, shop.context)
    p_value = 1.0
    if reason is None:
        p_value = p_value_of(shop, candidate, others, pool)
        if p_value > shop.settings.level:
            reason = f"p = {p_value:.2g} after the multiplicity of the search"
    fault = held_out_fault(shop, others, candidate.trial) if reason is None else None
    if reason is not None or (fault is not None and not candidate.trial.is_free_form):
        refused.append(refusal(candidate, reason or str(fault)))
        return None
    return Accepted(candidate.trial, candidate.gain, p_value, stands_in=fault is None)


def too_little(shop: Workshop, candidate: Score, accepted: list[Accepted]) -> str | None:
    """Why a candidate only wipes up what an earlier addition left; None if it does more."""
    for earlier in accepted:
        if not set(earlier.trial.group) & set(candidate.trial.group):
            continue
        share = candidate.gain / max(
            _gain_of_earlier(shop, accepted, earlier, candidate.trial), 1e-300
        )
        if share >= shop.settings.mending_share:
            continue
        others = [a.trial for a in accepted]
        if share < shop.settings.mop_up_floor and not (
            share >= MUCH_LESS and _like_nothing_else(shop, candidate, others)
        ):
            return f"gains {share:.1%} of what {earlier.trial.name} gained"
        if _outdoes(shop, candidate, earlier, others):
            continue
        if share < shop.settings.family_floor and _families(earlier) & _families(candidate):
            return f"gains {share:.1%} of what {earlier.trial.name}, its like, gained"
        mend = _mend_that_covers(shop, candidate, earlier, others)
        if mend is not None:
            return f"{mend} would mend the formula of {earlier.trial.name} as well"
    others = [a.trial for a in accepted]
    residual = shop.fit(others, shop.layout(candidate.trial)).fit.residual
    share = candidate.gain / float(np.sum(residual[list(candidate.trial.group)] ** 2))
    if share < shop.settings.least_share:
        return f"removes {share:.2%} of the residual's variance"
    return None


def _gain_of_earlier(
    shop: Workshop, accepted: list[Accepted], earlier: Accepted, trial: Trial
) -> float:
    """What an earlier addition gains beside the others, at the joints on which a trial acts.

    No more than at its acceptance: others may have taken its place meanwhile.
    """
    if set(earlier.trial.group) <= set(trial.group):
        return earlier.gain
    others = [a.trial for a in accepted if a is not earlier]
    gain = gain_at(shop, list(trial.group), others, earlier.trial, shop.layout(trial))
    return min(earlier.gain, max(gain, 0.0))


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


def share_needed(free: Sequence[Trial], named: Trial, settings: DiagnosisSettings) -> float:
    """Share of what free-form terms explain that a named effect must reach to keep its name."""
    if any(is_own(t, named) for t in free):
        return settings.own_family_share
    if any(t.is_share for t in free):  # one parameter, less than most names have
        return 1.0
    if any(isinstance(t.effect, FreeForm) and t.effect.varies for t in free):
        return settings.foreign_share
    return settings.family_share


def _families(item: Accepted | Score) -> set[str]:
    return set() if item.trial.is_free_form else set(CATALOGUE[item.trial.name].families)


def held_out_fault(shop: Workshop, others: Sequence[Trial], trial: Trial) -> str | None:
    """Why an addition does not pay on rows that it was not fitted to; None if it does."""
    if other := differs_alone(shop, others, trial) or comes_at_once(shop, others, trial):
        return other
    layout = shop.layout(trial)
    before, after = (shop.fit(chosen, layout, bend=False) for chosen in (others, [*others, trial]))
    folds = shop.settings.folds
    gain, others_gain = cross_validate(after, folds).gain_over(cross_validate(before, folds))
    if others_gain <= 0:
        return f"left-out segments: gain {gain:.3g}, {others_gain:.3g} without the best of them"
    old, new = shop.foretold(others, [*others, trial])
    if old is None or new is None:
        return None
    is_curve = trial.is_free_form and not trial.is_share
    if costs(old, new, shop.baseline.floor.deviation, 0.0 if is_curve else PRICE):
        return f"validation error changes by the factors {np.round(new / old, 3).tolist()}"
    return None


def costs(
    old: Float[ndarray, " joints"],
    new: Float[ndarray, " joints"],
    floor: Float[ndarray, " joints"],
    price: float = PRICE,
) -> bool:
    """Whether held-out errors rise, or too much at one joint for what the others win.

    Args:
        old: (n,) root mean squares before [N m].
        new: After.
        floor: (n,) standard deviation of the noise [N m].
        price: Share of what joints win that others may lose.
    """
    ratio = new / old
    if price > 0:
        # Where a joint lacks most of what it does, all that is added moves its error: what others
        # win counts as the joint's likelihood does, and in squares of the floor no less is won.
        shares, squares = -2 * np.log(ratio), (old**2 - new**2) / floor**2
        dear = _won(-shares) > price * _won(shares) or _won(-squares) > _won(squares)
    else:
        dear = True
    return bool(np.mean(ratio**2) >= 1 or (ratio.max() > WORSE and dear))


def _won(falls: Float[ndarray, " joints"]) -> float:
    return float(np.maximum(falls, 0.0).sum())


def refusal(candidate: Score | Accepted, reason: str) -> Refused:
    """A candidate, or what was accepted once, turned down in words."""
    trial = candidate.trial
    return Refused(str(trial.key[0]), trial.joint, candidate.gain, reason)


def at_home(shop: Workshop, item: Accepted) -> Accepted:
    """An addition on the rows of new tables."""
    return dataclasses.replace(item, trial=shop.renewed(item.trial))
