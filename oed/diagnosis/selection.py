"""Which additions stay: competition, exchange, multiplicity, held-out gain, plausibility."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from oed.diagnosis.free_form import FreeForm
from oed.diagnosis.judgement import (
    COVERED,
    Accepted,
    Refused,
    held_out_fault,
    judge,
    refusal,
    too_little,
    within,
)
from oed.diagnosis.restraint import restrained
from oed.diagnosis.ripening import is_unripe, ripened
from oed.diagnosis.scan import (
    Score,
    refine,
    scan,
    score,
)
from oed.diagnosis.trials import Trial, free_form_trials
from oed.diagnosis.turning import NAME as GRAVITY
from oed.diagnosis.turning import accepted_tilt, far_turned, turned
from oed.diagnosis.workbench import Augmented, moved
from oed.diagnosis.workshop import Workshop
from oed.dynamics.effects.catalogue import CATALOGUE

# Ratio of the held-out error that a free-form term must reach: it knows nothing of physics that
# would carry it to the next motion.
BETTER = 0.95
UNRIPE_SHARE = 0.2  # of the best gain, from which on a candidate is worth evaluating anew
MOST_EXCHANGES = 2  # rounds after each addition; exchanges could go round in circles


@dataclass(frozen=True)
class Selection:
    """Outcome of the search.

    Attributes:
        accepted: Additions in the order of their acceptance.
        found: The fit with all of them.
        refused: What was turned down on the way.
    """

    accepted: tuple[Accepted, ...]
    found: Augmented
    refused: tuple[Refused, ...]

    @property
    def trials(self) -> tuple[Trial, ...]:
        """The additions that are part of the model."""
        return tuple(a.trial for a in self.accepted if a.stands_in)


def search(shop: Workshop) -> tuple[Workshop, Selection]:
    """Add, exchange and drop until nothing passes all tests; the tables may be made anew."""
    accepted: list[Accepted] = []
    refused: list[Refused] = []
    declared, tilt_p_value = shop, 0.0
    shop = far_turned(shop) or shop
    while len(accepted) + shop.is_turned < shop.settings.max_effects:
        pick = _next_physical(shop, accepted, refused)
        if pick is None:
            break
        if pick.trial.name == GRAVITY:
            shop, tilt_p_value = turned(shop, [a.trial for a in accepted]), pick.p_value
            if not shop.is_turned:
                break
        else:
            accepted.append(pick)
        accepted = _settle(shop, [_at_home(shop, a) for a in accepted])
        sharper = shop.sharpened([a.trial for a in accepted])
        if sharper is not None:
            shop = sharper
            accepted = _settle(shop, [_at_home(shop, a) for a in accepted])
    for _ in range(shop.settings.max_effects):
        pick = _next_free_form(shop, accepted, refused)
        if pick is None:
            break
        accepted.append(pick)
    accepted = _review_names(shop, accepted, refused)
    tilt = []
    if shop.is_turned:
        shop = turned(shop, [a.trial for a in accepted if a.stands_in])
        accepted = [_at_home(shop, a) for a in accepted]
        tilt = [accepted_tilt(shop, declared, tilt_p_value)]
    accepted = [*tilt, *_drop_superfluous(shop, accepted, refused)]
    trials = [a.trial for a in accepted if a.stands_in]
    found = shop.fit(trials, shop.layout_for(trials))
    return shop, Selection(tuple(accepted), found, tuple(refused))


def _at_home(shop: Workshop, item: Accepted) -> Accepted:
    """An addition on the rows of new tables."""
    trial = item.trial
    rows = shop.layout(trial).rows
    trial = moved(trial, rows, shop.context, contrast=trial.contrast)
    return dataclasses.replace(item, trial=trial)


def ranked(
    shop: Workshop,
    pool: Sequence[Trial],
    others: Sequence[Trial],
    most: int,
    *,
    ripe: bool = False,
) -> list[Score]:
    """Refined candidates beside some additions, best evidence first.

    Args:
        shop: The laid-out data.
        pool: Candidates, over the grids of their shapes.
        others: Additions.
        most: Candidates that are refined.
        ripe: Whether those that act on the torque itself are evaluated on what they leave.
    """
    keys = {t.key for t in others}
    if shop.is_turned:
        pool = [t for t in pool if t.name != GRAVITY]
    found: list[Score] = []
    rows = shop.full.rows.count
    for between in (False, True):
        layout = shop.full if between else shop.mean
        part = [t for t in pool if t.between_repetitions == between and t.key not in keys]
        if not part:
            continue
        fit = shop.fit(others, layout).fit
        scores = scan(part, fit)
        # By surprise for the small effect of a quiet joint, by gain for the large one that
        # makes its joint's residual loud.
        leading = {s.trial.key: s for s in scores[:most]}
        leading |= {s.trial.key: s for s in sorted(scores, key=lambda s: -s.gain)[:most]}
        refined = [refine(s, fit, shop.context) for s in leading.values()]
        promising = UNRIPE_SHARE * max(s.gain for s in refined)
        found += [
            ripened(shop, [t for t in part if t.key == s.trial.key], others, fit)
            if ripe and is_unripe(s.trial) and s.gain > promising and s.evidence(rows) > 0
            else s
            for s in refined
        ]
    return sorted(found, key=lambda s: -s.evidence(rows))


def simplest_first(shop: Workshop, candidates: list[Score]) -> list[Score]:
    """Where the evidence does not decide, the one that cancels least against the model first."""
    if not candidates:
        return []
    rows = shop.full.rows.count
    best = candidates[0].evidence(rows)
    level = [c for c in candidates if c.evidence(rows) > best - shop.settings.decisive]
    return [*sorted(level, key=lambda c: c.cancelled), *candidates[len(level) :]]


def _next_physical(
    shop: Workshop, accepted: list[Accepted], refused: list[Refused]
) -> Accepted | None:
    others = [a.trial for a in accepted]
    candidates = simplest_first(
        shop, ranked(shop, shop.physical, others, shop.settings.refined, ripe=True)
    )
    rivals = ranked(shop, shop.smooth, others, shop.settings.refined)
    for candidate in candidates:
        if candidate.evidence(shop.full.rows.count) <= 0:
            break
        better = _outdone_by(shop, candidate, rivals, others)
        if better is not None:
            reason = (
                f"{better.trial.key[0]} explains {better.gain / candidate.gain:.2g} times as much"
            )
            refused.append(refusal(candidate, reason))
            continue
        passed = judge(shop, candidate, accepted, shop.physical, refused)
        if passed is not None:
            return passed
    return None


def _next_free_form(
    shop: Workshop, accepted: list[Accepted], refused: list[Refused]
) -> Accepted | None:
    others = [a.trial for a in accepted]
    pool = (*shop.smooth, *shop.smooth_pairs)
    candidates = ranked(shop, pool, others, shop.settings.refined)
    for candidate in candidates:
        if candidate.evidence(shop.full.rows.count) <= shop.settings.free_form_margin:
            break
        passed = judge(shop, candidate, accepted, pool, refused)
        if passed is not None:
            return _standing_in(shop, passed, others)
    return None


def _standing_in(shop: Workshop, item: Accepted, others: Sequence[Trial]) -> Accepted:
    """A free-form term as far as the data determine it, part of the model if it then predicts."""
    joint = item.trial.joint
    found = shop.fit(others, shop.layout(item.trial))
    plain = shop.validation_rms(found)
    size = shop.size_of_residual(found, joint)
    choices = [
        trial
        for whole in (item.trial, *_finer(shop, item.trial))
        for trial in restrained(whole, found.fit, size)
    ]
    ratios = [0.0] * len(choices)
    if plain is not None:
        fits = (shop.fit([*others, t], shop.layout(t), bend=False) for t in choices)
        ratios = [float(shop.validation_rms(fit)[joint] / plain[joint]) for fit in fits]
    for ratio, trial in sorted(zip(ratios, choices, strict=True), key=lambda pair: pair[0]):
        if ratio >= BETTER:
            break
        if held_out_fault(shop, others, trial) is None:
            return dataclasses.replace(item, trial=trial, stands_in=True)
    return dataclasses.replace(item, stands_in=False)


def _finer(shop: Workshop, trial: Trial) -> list[Trial]:
    """The term with twice the pieces: what was noticed may be finer than what noticed it."""
    effect = trial.effect
    if not isinstance(effect, FreeForm):
        return []
    term = dataclasses.replace(effect, coordinates=tuple(c.halved() for c in effect.coordinates))
    return free_form_trials([term], shop.layout(trial).rows, contrast=trial.contrast)


def _outdone_by(
    shop: Workshop, candidate: Score, rivals: list[Score], others: Sequence[Trial]
) -> Score | None:
    """A free-form term that is better by far, and leaves little for the candidate to explain."""
    rows = shop.full.rows.count
    for rival in rivals:
        if rival.evidence(rows) - candidate.evidence(rows) < shop.settings.free_form_margin:
            break
        own = within(rival.trial.effect.depends_on, candidate.trial)
        share = shop.settings.own_family_share if own else shop.settings.family_share
        if candidate.gain > share * rival.gain:
            continue
        if candidate.trial.joint == rival.trial.joint or _covered(shop, candidate, rival, others):
            return rival
    return None


def _covered(shop: Workshop, candidate: Score, rival: Score, others: Sequence[Trial]) -> bool:
    """Whether most of a candidate's gain is gone beside a term of another joint."""
    layout = shop.layout(candidate.trial)
    fit = shop.fit([*others, rival.trial], layout).fit
    return score(candidate.trial, fit.projection, fit.residual).gain < COVERED * candidate.gain


def _settle(shop: Workshop, accepted: list[Accepted]) -> list[Accepted]:
    """Refit, re-examine each addition beside the others, exchange or drop it."""
    for _ in range(MOST_EXCHANGES):
        trials = [a.trial for a in accepted]
        shop.update_context(shop.fit(trials, shop.layout_for(trials)))
        changed = False
        for k in range(len(accepted)):
            rest = [a for i, a in enumerate(accepted) if i != k]
            best = _best_in_place(shop, accepted[k], rest)
            changed |= best.trial.key != accepted[k].trial.key
            accepted = [*accepted[:k], best, *accepted[k + 1 :]]
        if not changed:
            break
    return _best_subset(shop, accepted)


def _best_subset(shop: Workshop, accepted: list[Accepted]) -> list[Accepted]:
    """The subset of the additions with the best evidence: two that cancel both go."""
    best, best_value = accepted, np.inf
    layout = shop.layout_for([a.trial for a in accepted])
    penalty = np.log(shop.full.rows.count)
    for size in range(1, len(accepted) + 1):
        for subset in combinations(accepted, size):
            found = shop.fit([a.trial for a in subset], layout)
            value = found.fit.squares + penalty * found.fit.projection.rank
            # A larger subset must be better by a margin, since it had more chances.
            if value < best_value - shop.settings.decisive:
                best, best_value = list(subset), value
    return best


def _best_in_place(shop: Workshop, current: Accepted, rest: list[Accepted]) -> Accepted:
    """The addition with its shape refined, or a better one for its place."""
    others = [a.trial for a in rest]
    rows = shop.full.rows.count
    layout = shop.layout(current.trial)
    fit = shop.fit(others, layout).fit
    own = moved(current.trial, layout.rows, shop.context, contrast=current.trial.contrast)
    here = refine(score(own, fit.projection, fit.residual), fit, shop.context)
    if not others or current.trial.is_free_form:
        return Accepted(here.trial, here.gain, current.p_value)
    for rival in ranked(shop, shop.physical, others, 2):
        if rival.evidence(rows) <= here.evidence(rows) + shop.settings.decisive:
            break
        if rival.trial.key == here.trial.key:
            continue
        entry = CATALOGUE[rival.trial.name]
        trial = rival.trial
        if (
            too_little(shop, rival, rest) is None
            and entry.plausible(shop.context, trial.target, trial.values, rival.coefficients)
            is None
            and held_out_fault(shop, others, trial) is None
        ):
            return Accepted(trial, rival.gain, current.p_value)
    return Accepted(here.trial, here.gain, current.p_value)


def _review_names(
    shop: Workshop, accepted: list[Accepted], refused: list[Refused]
) -> list[Accepted]:
    """Drop names that a free-form term of their joint makes superfluous.

    A name stays where it explains nearly all that name and free form explain together (the
    same physics in a slightly other formula), or where nothing else can do its part.
    """
    free = [a for a in accepted if a.trial.is_free_form]
    kept = list(accepted)
    for joint in {a.trial.joint for a in free}:
        named = [a for a in kept if not a.trial.is_free_form and a.trial.joint in (joint, None)]
        for item in named:
            rest = [a.trial for a in kept if a is not item]
            bare = [t for t in rest if not (t.is_free_form and t.joint == joint)]
            layout = shop.layout_for([a.trial for a in kept])
            whole = shop.fit([a.trial for a in kept], layout).fit.squares
            without_free = shop.fit([*bare, item.trial], layout).fit.squares
            without_both = shop.fit(bare, layout).fit.squares
            without_name = shop.fit(rest, layout).fit.squares
            own = any(
                within(a.trial.effect.depends_on, item.trial)
                for a in free
                if a.trial.joint == joint
            )
            share = shop.settings.own_family_share if own else shop.settings.family_share
            together = without_both - whole
            alone = without_both - without_free
            needed = without_name - whole
            if alone < share * together and needed < (
                0.1 * together + shop.settings.free_form_margin
            ):
                kept = [a for a in kept if a is not item]
                reason = f"free form explains its part: {alone / together:.0%} of what both do"
                refused.append(Refused(item.trial.name, item.trial.joint, item.gain, reason))
    return kept


def _drop_superfluous(
    shop: Workshop, accepted: list[Accepted], refused: list[Refused]
) -> list[Accepted]:
    """Drop names that gain nothing beside the others."""
    kept = list(accepted)
    for item in accepted:
        if item.trial.is_free_form:
            continue
        layout = shop.layout_for([a.trial for a in kept])
        whole, without = (
            shop.fit([a.trial for a in kept if a.stands_in and a is not left_out], layout).fit
            for left_out in (None, item)
        )
        needed = without.squares - whole.squares
        columns = 0 if item.trial.fixed else len(item.trial.effect.parameters)
        if needed < (columns + item.trial.shapes) * np.log(shop.full.rows.count):
            kept = [a for a in kept if a is not item]
            reason = f"gains {needed:.3g} beside the other additions"
            refused.append(Refused(item.trial.name, item.trial.joint, item.gain, reason))
    return kept
