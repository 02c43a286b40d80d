"""Whether one candidate may be added: plausible, significant, and paying on what it has not seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.accepted import Accepted, Refused, refusal
from oed.diagnosis.candidates.chance import p_value_of
from oed.diagnosis.candidates.leftovers import is_own, too_little
from oed.diagnosis.candidates.open_shapes import shapes_beside
from oed.diagnosis.candidates.standstill import acts_at_standstill
from oed.diagnosis.candidates.within import comes_at_once, differs_alone
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.tables.held_out import cross_validate
from oed.diagnosis.tables.workbench import comes_first, early_and_late
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.bodies import is_no_body
from oed.diagnosis.terms.scores import Score, implausible
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.noise.addition import normal_equations
from oed.dynamics.effects.smooth_term import FreeForm

WORSE = 1.02  # ratio up to which a joint's held-out error may rise while the sum falls
# Share of what joints win, in -2 log likelihood, that others may lose to a named effect: it moves
# parameters that all rows share, and so does a share of another joint's torque. To a curve
# that claims no physics nobody has to lose.
PRICE = 1 / 3
EARLY_AND_LATE = "a torque that comes first is not late as well"


def judge(
    shop: Workshop,
    candidate: Score,
    accepted: list[Accepted],
    pool: Sequence[Trial],
    refused: list[Refused],
    *,
    partners: Sequence[Trial] = (),
) -> Accepted | None:
    """All tests in the order of their cost; the first that fails is the reason given.

    Args:
        shop: The laid-out data.
        candidate: Refined beside all others.
        accepted: Additions so far.
        pool: All that the search tries.
        refused: Takes in what is turned down.
        partners: Further additions beside which it stands, known to be all that there is with it:
            then it may gain far less than one of them.
    """
    others = [*(a.trial for a in accepted), *partners]
    reason = too_little(shop, candidate, accepted, partners) or implausible(candidate, shop.context)
    reason = reason or no_body(shop, others, candidate)
    reason = reason or acts_at_standstill(shop, candidate.trial, candidate.coefficients)
    if early_and_late([*others, candidate.trial]) and not early_and_late(others):
        reason = reason or EARLY_AND_LATE
    if reason is None:
        p_value = p_value_of(shop, candidate, others, pool)
        if p_value > shop.settings.level:
            reason = f"p = {p_value:.2g} after the multiplicity of the search"
    fault = held_out_fault(shop, others, candidate.trial) if reason is None else None
    if reason is not None or (fault is not None and not candidate.trial.is_free_form):
        refused.append(refusal(candidate, reason or str(fault)))
        return None
    return Accepted(candidate.trial, candidate.gain, stands_in=fault is None)


def share_needed(free: Sequence[Trial], named: Trial, settings: DiagnosisSettings) -> float:
    """Share of what free-form terms explain that a named effect must reach to keep its name."""
    if any(is_own(t, named) for t in free):
        return settings.own_family_share
    if any(t.is_share for t in free):  # one parameter, less than most names have
        return 1.0
    if any(isinstance(t.effect, FreeForm) and t.effect.varies for t in free):
        return settings.foreign_share
    return settings.family_share


def held_out_fault(shop: Workshop, others: Sequence[Trial], trial: Trial) -> str | None:
    """Why an addition does not pay on rows that it was not fitted to; None if it does."""
    if other := differs_alone(shop, others, trial) or comes_at_once(shop, others, trial):
        return other
    layout = shop.layout(trial)
    before, after = (shop.fit(chosen, layout, bend=False) for chosen in (others, [*others, trial]))
    if comes_first(trial):
        falls = np.sum(before.fit.residual**2 - after.fit.residual**2, axis=1)
        if _won(-falls) > PRICE * _won(falls):
            return "some joints would rather come late"
    folds = shop.settings.folds
    gain, others_gain = cross_validate(after, folds).gain_over(cross_validate(before, folds))
    if others_gain <= 0:
        return f"left-out segments: gain {gain:.3g}, {others_gain:.3g} without the best of them"
    old, new = shop.foretold(others, [*others, trial], as_it_is=trial.is_free_form)
    if old is None or new is None:
        return None
    price = 0.0 if trial.is_free_form and not trial.is_share else PRICE
    floor, counted = shop.baseline.floor.deviation, shop.unseen_full.counted
    if not costs(old, new, floor, counted, price):
        return None
    risen = np.flatnonzero(new > old).tolist()
    if np.min(new / old) < 1 and (moved := shapes_beside(shop, others, trial, risen)):
        _, best = shop.foretold(others, [*moved, trial], as_it_is=trial.is_free_form)
        if best is not None and not costs(old, best, floor, counted, price):
            return None
    return f"validation error changes by the factors {np.round(new / old, 3).tolist()}"


def no_body(shop: Workshop, others: Sequence[Trial], candidate: Score) -> str | None:
    """Why a load cannot be one; None if it can, or a candidate is none."""
    trial = candidate.trial
    fit = shop.fit(others, shop.layout(trial)).fit
    gram = normal_equations(fit.projection, fit.residual, trial.group).gram
    covariance = np.linalg.pinv(gram, hermitian=True)
    if is_no_body(trial, candidate.coefficients, covariance):
        return "no body has such inertial parameters"
    return None


def costs(
    old: Float[ndarray, " joints"],
    new: Float[ndarray, " joints"],
    floor: Float[ndarray, " joints"],
    counted: Float[ndarray, " joints"],
    price: float = PRICE,
) -> bool:
    """Whether held-out errors rise, or too much at one joint for what the others win.

    Args:
        old: (n,) root mean squares before [N m].
        new: After.
        floor: (n,) standard deviation of the noise [N m].
        counted: (n,) rows that count; of slow noise many are one, and its joint is foretold as it may.
        price: Share of what joints win that others may lose.
    """
    rises = _rises(old, new, counted)
    if price > 0:
        # An error below the noise is luck, of which no more than the noise is lost. Where a joint
        # lacks most of what it does, all that is added moves its error; and in squares of the
        # floor no less is won.
        beyond = _rises(np.maximum(old, np.minimum(new, floor)), new, counted)
        squares = counted * (old**2 - new**2) / floor**2
        dear = _won(beyond) > price * _won(-rises) or _won(-squares) > _won(squares)
    else:
        dear = True
    return bool(np.sum(rises) >= 0 or ((new / old).max() > WORSE and dear))


def rise(
    old: Float[ndarray, " joints"],
    new: Float[ndarray, " joints"],
    counted: Float[ndarray, " joints"],
) -> float:
    """By how much held-out errors rise, each as its likelihood counts it.

    Squared ratios would not do: one error that rises by a half would outweigh one that falls to
    nothing.

    Args:
        old: (n,) root mean squares before [N m].
        new: After.
        counted: (n,) rows that count.
    """
    return float(np.sum(_rises(old, new, counted)))


def _rises(
    old: Float[ndarray, " joints"],
    new: Float[ndarray, " joints"],
    counted: Float[ndarray, " joints"],
) -> Float[ndarray, " joints"]:
    return counted * np.log(new / old)


def _won(falls: Float[ndarray, " joints"]) -> float:
    return float(np.maximum(falls, 0.0).sum())
