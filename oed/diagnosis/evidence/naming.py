"""What of a selection holds in its exact form, and under which names."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

from oed.diagnosis.candidates.judgement import EARLY_AND_LATE, WORSE
from oed.diagnosis.candidates.paying import validation_gain
from oed.diagnosis.candidates.standstill import acts_at_standstill
from oed.diagnosis.candidates.turning import GRAVITY
from oed.diagnosis.candidates.usual import plainer
from oed.diagnosis.evidence.at_its_end import is_at_its_end
from oed.diagnosis.evidence.doubt import doubtful_name
from oed.diagnosis.evidence.final_model import FinalModel, lost_when_repeated
from oed.diagnosis.evidence.impossible_load import impossible_load
from oed.diagnosis.evidence.never_worse import never_worse
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
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.tables.joint_sign import is_law_of_speed
from oed.diagnosis.tables.workbench import Augmented, early_and_late
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.experiment.preparation.prepared import Prepared


def named(
    shop: Workshop,
    selection: Selection,
    validation: tuple[Prepared, ...],
    before: FinalModel,
) -> tuple[Workshop, Selection, FinalModel, tuple[FoundEffect, ...]]:
    """What is sure, under the plainest of the names that the data prefer, and the tables it stands on.

    Args:
        shop: The laid-out data.
        selection: What the search added.
        validation: Recordings that the exact form must predict.
        before: The base model.
    """
    barred: set[tuple[str, object]] = set()
    while True:
        shop, selection, after, found = _sure(shop, selection, validation, before)
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
            return shop, selection, after, with_own_parts(effects)
        reason = "another name would foretell more beside what has none"
        shop, selection = _without(shop, selection, mistaken, reason)


def _sure(
    shop: Workshop,
    selection: Selection,
    validation: tuple[Prepared, ...],
    before: FinalModel,
) -> tuple[Workshop, Selection, FinalModel, Augmented]:
    """What holds in its exact form and beyond its own uncertainty, installed and as it was fitted."""
    while True:
        selection, after = never_worse(shop, selection, validation, before)
        lost = lost_when_repeated(shop, selection.found, after)
        if lost is not None:
            reason = "in its exact form it raises the error of the single repetitions"
            selection = selection.without(shop, lost, reason)
            continue
        found = with_uncertainty(shop, selection.found)
        doubt = _doubt(shop, selection, found)
        if doubt is None:
            return shop, selection, after, found
        if doubt.instead is None:
            shop, selection = _without(shop, selection, doubt.trial, doubt.reason)
        else:
            selection = selection.exchanged(shop, doubt.trial, doubt.instead)


def _without(
    shop: Workshop, selection: Selection, trial: Trial, reason: str
) -> tuple[Workshop, Selection]:
    """A selection without a name, and signs with it that had turned to suit a law of speed.

    They would now be wrong by its whole size, and all other names be held to account for that.
    """
    left = selection.without(shop, trial, reason)
    return left.sharpened(shop) if is_law_of_speed(trial) else (shop, left)


@dataclass(frozen=True)
class _Doubt:
    """A name that something speaks against.

    Attributes:
        trial: The name.
        reason: What does.
        instead: The same effect by a formula that nothing is known against; None if it has none.
    """

    trial: Trial
    reason: str
    instead: Trial | None = None


def _doubt(shop: Workshop, selection: Selection, found: Augmented) -> _Doubt | None:
    """The first doubt of a name, in the order of what it costs to ask; None if there is none."""
    if (trial := doubtful_name(shop, found)) is not None:
        return _Doubt(trial, "its own interval holds zero")
    if (trial := impossible_load(found)) is not None:
        return _Doubt(trial, "no body has such inertial parameters")
    if (trial := told_by_a_sign(shop, found)) is not None:
        return _Doubt(trial, "a sign that turns faster tells as much")
    if (doubt := _standing_still(shop, found)) is not None:
        return doubt
    if (doubt := _implausible(shop, selection, found)) is not None:
        others = [t for t in selection.trials if t.key != doubt.trial.key]
        return dataclasses.replace(doubt, instead=plainer(shop, others, doubt.trial))
    if (trial := _weakest(selection, early_and_late(found.chosen))) is not None:
        return _Doubt(trial, EARLY_AND_LATE)
    if (trial := _harmful(shop, selection.trials)) is not None:
        return _Doubt(trial, "beside all other additions it raises the validation error")
    return None


def _standing_still(shop: Workshop, found: Augmented) -> _Doubt | None:
    """A name that by now acts only where its joint sticks."""
    for trial, coefficients in zip(found.chosen, found.coefficients, strict=True):
        reason = None if trial.is_free_form else acts_at_standstill(shop, trial, coefficients)
        if reason is not None:
            return _Doubt(trial, reason)
    return None


def _implausible(shop: Workshop, selection: Selection, found: Augmented) -> _Doubt | None:
    """A name whose parameters cannot be what it says, as they are after all.

    They were plausible when it was added; beside others, and refined, they may have run away. Of
    several, such as a coupling and its mirror image, the one that explained least goes first.
    """
    gains = {item.trial.key: item.gain for item in selection.accepted}
    worst = None
    for trial, coefficients in zip(found.chosen, found.coefficients, strict=True):
        if trial.is_free_form or trial.name == GRAVITY:
            continue
        check = CATALOGUE[trial.name].plausible
        reason = check(shop.context, trial.target, trial.values, coefficients)
        if reason is not None and (worst is None or gains[trial.key] < gains[worst.trial.key]):
            worst = _Doubt(trial, reason)
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
