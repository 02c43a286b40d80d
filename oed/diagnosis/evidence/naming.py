"""What of a selection holds in its exact form, and under which names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from oed.diagnosis.candidates.judgement import EARLY_AND_LATE, WORSE, costs, rise
from oed.diagnosis.candidates.paying import validation_gain
from oed.diagnosis.candidates.ripening import is_late
from oed.diagnosis.candidates.turning import GRAVITY
from oed.diagnosis.data.prepared import Prepared
from oed.diagnosis.evidence.at_its_end import is_at_its_end
from oed.diagnosis.evidence.doubt import doubtful_name
from oed.diagnosis.evidence.final_model import (
    FinalModel,
    errors_of,
    final_with,
    lost_when_repeated,
)
from oed.diagnosis.evidence.impossible_load import impossible_load
from oed.diagnosis.evidence.own_parts import with_own_parts
from oed.diagnosis.evidence.sharper_sign import told_by_a_sign
from oed.diagnosis.evidence.uncertainty import with_uncertainty
from oed.diagnosis.evidence.verdict import (
    FoundEffect,
    describe_effects,
    describe_unexplained,
    outdone,
    preferred_rival,
    riddles,
)
from oed.diagnosis.search.exchange import foretelling
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.tables.predict import rms
from oed.diagnosis.tables.workbench import Augmented, early_and_late
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.effects.catalogue import CATALOGUE


def named(
    shop: Workshop,
    selection: Selection,
    validation: tuple[Prepared, ...],
    before: FinalModel,
) -> tuple[Selection, FinalModel, tuple[FoundEffect, ...]]:
    """What is sure, under the plainest of the names that the data prefer.

    Args:
        shop: The laid-out data.
        selection: What the search added.
        validation: Recordings that the exact form must predict.
        before: The base model.
    """
    barred: set[tuple[str, object]] = set()
    while True:
        selection, after, found = _sure(shop, selection, validation, before)
        effects = describe_effects(shop, selection, found)
        ended = {e.trial.key for e in effects if is_at_its_end(shop, e)}
        exchange = preferred_rival(effects, shop.settings.decisive, barred, ended)
        if exchange is not None:
            barred.add(exchange[0].key)
            selection = selection.exchanged(shop, *exchange)
            continue
        mistaken = None
        if riddles(effects, describe_unexplained(shop, selection)):
            mistaken = outdone(effects, shop.settings.decisive)
        if mistaken is None:
            return selection, after, with_own_parts(effects)
        reason = "another name would foretell more beside what has none"
        selection = selection.without(shop, mistaken, reason)


def _sure(
    shop: Workshop,
    selection: Selection,
    validation: tuple[Prepared, ...],
    before: FinalModel,
) -> tuple[Selection, FinalModel, Augmented]:
    """What holds in its exact form and beyond its own uncertainty, installed and as it was fitted."""
    while True:
        selection, after = _never_worse(shop, selection, validation, before)
        lost = lost_when_repeated(shop, selection.found, after)
        if lost is not None:
            reason = "in its exact form it raises the error of the single repetitions"
            selection = selection.without(shop, lost, reason)
            continue
        found = with_uncertainty(shop, selection.found)
        doubtful, reason = doubtful_name(shop, found), "its own interval holds zero"
        if doubtful is None:
            doubtful, reason = impossible_load(found), "no body has such inertial parameters"
        if doubtful is None:
            doubtful, reason = told_by_a_sign(shop, found), "a sign that turns faster tells as much"
        if doubtful is None:
            doubtful, reason = _implausible(shop, selection, found)
        if doubtful is None:
            doubtful, reason = _weakest(selection, early_and_late(found.chosen)), EARLY_AND_LATE
        if doubtful is None:
            doubtful = _harmful(shop, selection.trials)
            reason = "beside all other additions it raises the validation error"
        if doubtful is None:
            return selection, after, found
        selection = selection.without(shop, doubtful, reason)


def _implausible(
    shop: Workshop, selection: Selection, found: Augmented
) -> tuple[Trial | None, str]:
    """A name whose parameters cannot be what it says, as they are after all; with the reason.

    They were plausible when it was added; beside others, and refined, they may have run away. Of
    several, such as a coupling and its mirror image, the one that explained least goes first.
    """
    gains = {item.trial.key: item.gain for item in selection.accepted}
    worst: tuple[Trial | None, str] = (None, "")
    for trial, coefficients in zip(found.chosen, found.coefficients, strict=True):
        if trial.is_free_form or trial.name == GRAVITY:
            continue
        check = CATALOGUE[trial.name].plausible
        reason = check(shop.context, trial.target, trial.values, coefficients)
        if reason is not None and (worst[0] is None or gains[trial.key] < gains[worst[0].key]):
            worst = (trial, reason)
    return worst


def _weakest(selection: Selection, trials: Sequence[Trial]) -> Trial | None:
    """Of some additions the one that explained least when it was added; None of none."""
    gains = {item.trial.key: item.gain for item in selection.accepted}
    return min(trials, key=lambda t: gains[t.key], default=None)


def _harmful(shop: Workshop, chosen: tuple[Trial, ...]) -> Trial | None:
    """A name without which what stands foretells the validation recordings better.

    It paid when it was added; free-form terms that came later may do its part, and better.
    """
    for trial in chosen:
        if trial.is_free_form or (trial.name == GRAVITY and shop.is_turned):
            continue
        gain = validation_gain(shop, chosen, trial)
        if gain is not None and gain < 1 - WORSE:
            return trial
    return None


def _never_worse(
    shop: Workshop,
    selection: Selection,
    validation: tuple[Prepared, ...],
    before: FinalModel,
) -> tuple[Selection, FinalModel]:
    """The augmented model in its exact form; additions that then raise the held-out error go.

    The search judges columns of first order where an effect acts on the whole model. Only the
    exact form, all parameters refitted together, can prove that nothing got worse. A late torque
    stays where it is less late and foretells more; else that addition goes without which the others
    foretell most, or all that claims no physics.
    """
    if not validation:
        return selection, final_with(shop, selection.found) if selection.trials else before
    weights = shop.baseline.noise_share(validation)
    old = rms(errors_of(before, validation), weights)
    floor, counted = shop.baseline.floor.deviation, shop.unseen_full.counted

    def tried(kept: Selection) -> _Tried:
        final = final_with(shop, kept.found) if kept.trials else before
        new = rms(errors_of(final, validation), weights)
        is_worse = bool(kept.trials) and costs(old, new, floor, counted)
        return _Tried(is_worse, rise(old, new, counted), kept, final)

    reason = "in its exact form it raises the validation error"
    late = [t for t in selection.trials if is_late(t)]
    found = tried(selection)
    while found.is_worse:
        kept = found.kept
        if late:
            moved = foretelling(shop, kept.trials, late[0])
            kept, late = kept.exchanged(shop, late[0], moved), late[1:]
            found = tried(kept)
        else:
            # Without the tilt that the tables are turned by, they stay turned: it goes last.
            loose = [t for t in kept.trials if not (t.name == GRAVITY and shop.is_turned)]
            fewer = [kept.without(shop, t, reason) for t in reversed(loose or kept.trials)]
            # Curves that do each other's part, or a name's, are no loss one by one.
            if sum(t.is_free_form for t in loose) > 1:
                fewer.append(_without_curves(shop, kept, reason))
            found = min(map(tried, fewer), key=lambda t: (t.is_worse, t.rise))
    return found.kept, found.final


def _without_curves(shop: Workshop, selection: Selection, reason: str) -> Selection:
    for trial in selection.trials:
        if trial.is_free_form:
            selection = selection.without(shop, trial, reason)
    return selection


@dataclass(frozen=True)
class _Tried:
    """Some additions in their exact form.

    Attributes:
        is_worse: Whether they cost more on the validation recordings than they win.
        rise: Of the validation errors above those of the base model.
        kept: The additions.
        final: The model with them.
    """

    is_worse: bool
    rise: float
    kept: Selection
    final: FinalModel
