"""Names looked at again when all is known that stands beside them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from oed.diagnosis.candidates.accepted import Accepted, Refused, refusal
from oed.diagnosis.candidates.judgement import no_body, share_needed
from oed.diagnosis.candidates.leftovers import COVERED, gain_at, is_own
from oed.diagnosis.candidates.margin import is_of_kind
from oed.diagnosis.candidates.paying import validation_gain
from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.candidates.telling import foretells_most
from oed.diagnosis.search.free_form_rivals import FULLER, in_more_terms
from oed.diagnosis.tables.workbench import is_pure_delay
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.restraint import restrained
from oed.diagnosis.terms.scores import inflation_of, score
from oed.diagnosis.terms.trials import Trial, free_form_trials
from oed.dynamics.effects.smooth_term import FreeForm

# Share by which what bends the model's own torque lowers a held-out error of noise: a lag or a soft
# gear smooths what the model predicts, and with it what encoder noise adds to that. A delay does not.
LEAST = 0.005
# Share of what a name and a free form explain together up to which that name is not missed.
SUPERFLUOUS = 0.1


def review_names(
    shop: Workshop, accepted: list[Accepted], refused: list[Refused]
) -> list[Accepted]:
    """Drop names that a free-form term of their joint makes superfluous.

    A name stays where it explains nearly all that name and free form explain together (the
    same physics in a slightly other formula), where it foretells more than they do, or where
    nothing else can do its part. Beside a term that is no freer form of it, it must have one.
    """
    free = [a for a in accepted if a.trial.is_free_form]
    kept = list(accepted)
    for joint in {a.trial.joint for a in free}:
        terms = [a for a in free if a.trial.joint == joint]
        named = [a for a in kept if not a.trial.is_free_form and a.trial.joint in (joint, None)]
        for item in named:
            bare = [a for a in kept if a is not item and all(a is not t for t in terms)]
            others = [a.trial for a in bare if a.stands_in]
            standing = [a.trial for a in terms if a.stands_in]
            alternatives = list(_in_its_place(shop, others, standing))
            if foretells_most(shop, others, item.trial, alternatives):
                continue
            layout = shop.layout_for([a.trial for a in (item, *terms)])
            without_both, without_free, without_name, whole = (
                shop.fit([a.trial for a in chosen], layout).fit.squares
                for chosen in (bare, [*bare, item], [a for a in kept if a is not item], kept)
            )
            # The free form as it was determined beside the name has left to it what it does best.
            tried = [shop.fit([*others, t], layout, bend=False) for t in alternatives]
            without_name = min([without_name, *(f.fit.squares for f in tried)])
            together, alone = without_both - whole, without_both - without_free
            share = share_needed([a.trial for a in terms], item.trial, shop.settings)
            fuller = in_more_terms(shop, item.trial, [a.trial for a in bare], layout)
            if fuller is not None:
                chosen = [*(a.trial for a in bare), fuller.trial]
                alone = without_both - shop.fit(chosen, layout, bend=False).fit.squares
                share = FULLER
            needless = alone < share * together and without_name - whole < (
                SUPERFLUOUS * together + shop.settings.free_form_margin
            )
            if needless or (
                without_name - whole < _price(shop, item.trial)
                and standing
                and not any(is_own(t, item.trial) for t in standing)
            ):
                kept = [a for a in kept if a is not item]
                reason = f"free form explains its part: {alone / together:.0%} of what both do"
                refused.append(refusal(item, reason))
    return kept


def _price(shop: Workshop, trial: Trial) -> float:
    """What an addition must gain for its parameters (Schwarz)."""
    return trial.freedom * float(np.log(shop.full.rows.count))


def _in_its_place(shop: Workshop, others: list[Trial], standing: list[Trial]) -> Iterator[Trial]:
    """Free-form terms as the data determine them where no name stands beside them."""
    for trial in standing:
        effect, layout = trial.effect, shop.layout(trial)
        if isinstance(effect, FreeForm):
            whole = dataclasses.replace(effect, mixing=None)
            (alone,) = free_form_trials([whole], layout.rows, contrast=trial.contrast)
            yield from restrained(alone, shop.fit(others, layout).fit)


def drop_superfluous(
    shop: Workshop, accepted: list[Accepted], refused: list[Refused]
) -> list[Accepted]:
    """Drop names that gain nothing beside the others, or nothing that was not fitted to.

    A free-form term of its joint, which may follow anything, is no reason against a name that
    the review has kept.
    """
    kept = list(accepted)
    for item in accepted:
        if item.trial.is_free_form:
            continue
        layout = shop.layout(item.trial)
        standing = [a for a in kept if a.stands_in and not a.trial.may_follow(item.trial)]
        whole, without = (
            shop.fit([a.trial for a in standing if a is not left_out], layout)
            for left_out in (None, item)
        )
        # What the whole model still lacks is chance to this addition.
        chance = float(inflation_of(whole.fit)[list(item.trial.group)].mean())
        unseen = shop.unseen_by([*(a.trial for a in standing), item.trial])
        left = unseen.left(whole)
        foretold = (unseen.left(without) - left) / np.maximum(left / unseen.counted, 1.0)
        needed = (without.fit.squares - whole.fit.squares) / chance + max(
            float(foretold.sum()), 0.0
        )
        predicts = validation_gain(shop, [a.trial for a in standing], item.trial)
        # Where the error is far above the noise, as much noise is a smaller share of it.
        joints = list(item.trial.group)
        loud = max(float((left / unseen.counted)[joints].mean()), 1.0)
        least = LEAST / loud if item.trial.fixed and not is_pure_delay(item.trial) else 0.0
        reason = None
        if needed < _price(shop, item.trial):
            reason = f"gains {needed:.3g} beside the other additions"
        elif predicts is not None and predicts <= least:
            reason = f"beside the other additions it lowers the validation error by {predicts:.1%}"
        elif any(a.trial.may_follow(item.trial) for a in kept):
            reason = _better_name(shop, [a.trial for a in kept if a is not item], item)
        if reason is not None:
            kept = [a for a in kept if a is not item]
            refused.append(refusal(item, reason))
    return kept


def drop_needless(
    shop: Workshop, accepted: list[Accepted], refused: list[Refused]
) -> list[Accepted]:
    """Drop free-form terms, the most needless first, that the evidence no longer asks for.

    They were added beside names that have found their places since, a tilt above all. What only says
    where something is missing takes the place of none that is part of the model.
    """
    kept, rows = list(accepted), shop.full.rows.count
    while True:
        found = []
        for item in (a for a in kept if a.trial.is_free_form):
            beside = [a for a in kept if a is not item]
            others = [a.trial for a in beside if a.stands_in or not item.stands_in]
            own = score(item.trial, shop.fit(others, shop.layout(item.trial)).fit)
            found.append((own.evidence(rows), own.gain, item))
        if not found:
            return kept
        evidence, gain, needless = min(found, key=lambda f: f[0])
        if evidence > 0:
            return kept
        kept = [a for a in kept if a is not needless]
        refused.append(refusal(needless, f"gains {gain:.3g} beside the other additions"))


def _better_name(shop: Workshop, others: list[Trial], item: Accepted) -> str | None:
    """Whether another name would now explain more: then none of them is what is there.

    Not what is left over where a free-form term follows all that the name stands for.
    """
    rows = shop.full.rows.count
    fit = shop.fit(others, shop.layout(item.trial)).fit
    here = score(shop.renewed(item.trial), fit).evidence(rows)
    for rival in ranked(shop, shop.in_place_of(item.trial), others, 1):
        if rival.trial.key == item.trial.key or is_of_kind(rival.trial, item.trial):
            continue
        if no_body(shop, others, rival) is not None:
            continue
        gain, joints = rival.gain, sorted(item.trial.group)
        if not set(rival.trial.group) <= set(joints):
            # What it does for other joints is no rival to a name here.
            gain = gain_at(shop, joints, others, rival.trial, shop.layout(rival.trial))
        evidence = gain - rival.price(rows)
        if gain >= COVERED * item.gain and evidence > here + shop.settings.decisive:
            return f"{rival.trial.name} would explain more beside what has no name"
    return None
