"""What a search found and what of it has a name, sought again where a name does not hold."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.accepted import Refused
from oed.diagnosis.candidates.clocks import by_other_clock
from oed.diagnosis.candidates.turning import GRAVITY
from oed.diagnosis.evidence.contradiction import checked_errors, held_out_rms
from oed.diagnosis.evidence.final_model import FinalModel, final_with, fit_final
from oed.diagnosis.evidence.naming import named
from oed.diagnosis.evidence.verdict import FoundEffect, outdone_by_tilt
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.search.selection import search, with_stand_ins
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.experiment.preparation.prepared import Prepared

Key = tuple[str, object]
# Ratio of a joint's test errors above which an addition is no gain: noise alone makes 1.03 of a true one.
RAISED = 1.05


@dataclass(frozen=True)
class Finding:
    """A search's outcome.

    Attributes:
        shop: The laid-out data, turned where a tilt was found.
        selection: What was added, with and without a name.
        before: The base model, fitted.
        after: The augmented model, fitted.
        effects: What has a name.
    """

    shop: Workshop
    selection: Selection
    before: FinalModel
    after: FinalModel
    effects: tuple[FoundEffect, ...]


def find(shop: Workshop, validation: tuple[Prepared, ...]) -> Finding:
    """Search, and name what holds.

    Where a tilt would tell more by far than a name that was found first, another search begins with
    it: to turn the tables changes what all others are worth.

    Args:
        shop: The laid-out data.
        validation: Recordings that the exact form must predict.
    """
    found = _found(shop, validation)
    outdone = outdone_by_tilt(found.effects, shop.settings.decisive)
    if outdone:
        other = _found(shop, validation, found.selection.refused, instead_of=outdone)
        if any(t.name == GRAVITY for t in other.selection.trials):
            return other
    return found


def uncontradicted(
    found: Finding, validation: tuple[Prepared, ...], test: tuple[Prepared, ...]
) -> Finding:
    """The same without what the test recordings contradict.

    Where a tilt raises the error of some joint clearly, all is sought anew as the base was declared, and
    the better of both stays. Terms that claim no physics stand aside first, for they extrapolate worst;
    then whatever raises the error of some joint clearly goes, and last of all every name.

    Args:
        found: What the search found.
        validation: Recordings that the exact form must predict.
        test: Recordings that can take back, and without validation recordings tell by which clock a
            change goes.
    """
    if not found.selection.trials or not test:
        return found
    raises = _test_ratios(found, test).max() > RAISED
    if found.shop.is_turned and (raises or _is_contradicted(found, test)):
        other = _found(found.shop.upright, validation, found.selection.refused, upright=True)
        found = min(found, other, key=lambda f: _squares(_test_ratios(f, test)))
    # Without validation recordings nobody has been asked whose clock a change goes by.
    if not validation and _is_contradicted(found, test):
        turned = _by_other_clocks(found)
        if not _is_contradicted(turned, test):
            found = turned
    if not _is_contradicted(found, test):
        found = _without_curves_that_raise(found, validation, test)
        return _without_what_raises(found, validation, test)
    if _curves(found.selection):
        found = _with_aside(found, validation, _curves(found.selection))
    found = _without_what_raises(found, validation, test)
    if not _is_contradicted(found, test):
        return found
    selection = found.selection
    for trial in _names(selection):
        selection = selection.without(found.shop, trial, "it does not lower the test error")
    return dataclasses.replace(found, selection=selection, after=found.before, effects=())


def _by_other_clocks(found: Finding) -> Finding:
    """The same with what changes in time going by the other clock, where that is open."""
    shop, selection = found.shop, found.selection
    for trial in _names(selection):
        turned = by_other_clock(shop, trial)
        if turned is not None:
            selection = selection.exchanged(shop, trial, turned)
    if selection is found.selection:
        return found
    return _renamed(found, selection, ())


def _with_aside(
    found: Finding, validation: tuple[Prepared, ...], terms: Collection[Trial]
) -> Finding:
    selection = found.selection.with_aside(found.shop, terms)
    return _renamed(found, selection, validation)


def _renamed(found: Finding, selection: Selection, validation: tuple[Prepared, ...]) -> Finding:
    before = found.before
    shop, selection, after, effects = named(found.shop, selection, validation, before)
    if shop is not found.shop:  # a law of speed fell, and the noise with its signs is another
        before = fit_final(shop.declared, shop.layout_for(selection.trials), before.model)
    return Finding(shop, selection, before, after, effects)


def _without_what_raises(
    found: Finding, validation: tuple[Prepared, ...], test: tuple[Prepared, ...]
) -> Finding:
    """The same without additions that clearly raise the test error of a joint, theirs or another.

    To add to one joint moves the parameters of all. Each that goes must lower all test errors
    together: each joint's against what it was, and in noise floors. That one goes first which
    lowers those of test and validation together most: luck in one is seldom luck in both.
    """
    shop, selection = found.shop, found.selection
    old, new = _test_errors(found, test)
    base = held_out_rms(shop, found.before, validation) if validation else None
    while selection.trials and (new / old).max() > RAISED:
        # All that was added stands on the tables that a tilt has turned.
        loose = [trial for trial in selection.trials if trial.name != GRAVITY]
        lower = []
        for fewer in [_less(shop, selection, trial) for trial in loose]:
            final = final_with(shop, fewer.found)
            _, errors = checked_errors(shop, fewer, found.before, final, test)
            if _squares(errors / old) < _squares(new / old) and _squares(errors) < _squares(new):
                left = _squares(errors / old)
                if base is not None:
                    left += _squares(held_out_rms(shop, final, validation) / base)
                lower.append((left, errors, fewer))
        if not lower:
            break
        _, new, selection = min(lower, key=lambda t: t[0])
    return found if selection is found.selection else _renamed(found, selection, validation)


def _squares(errors: Float[ndarray, " joints"]) -> float:
    return float(np.sum(errors**2))


def _less(shop: Workshop, selection: Selection, trial: Trial) -> Selection:
    if trial.is_free_form:
        return selection.with_aside(shop, [trial])
    return selection.without(shop, trial, "it raises the test error")


def _without_curves_that_raise(
    found: Finding, validation: tuple[Prepared, ...], test: tuple[Prepared, ...]
) -> Finding:
    """The same without terms that claim no physics where they raise a joint's test error.

    What came last goes first.
    """
    ratios = _test_ratios(found, test)
    for term in reversed(_curves(found.selection)):
        if term.joint is not None and ratios[term.joint] > 1:
            found = _with_aside(found, validation, [term])
            ratios = _test_ratios(found, test)
    return found


def _is_contradicted(found: Finding, test: tuple[Prepared, ...]) -> bool:
    """Whether all that the model was given does not lower the test error.

    A search through many candidates now and then takes noise for one of them, and a small gain
    on the validation recordings for its proof.
    """
    if not found.selection.trials or not test:
        return False
    return bool(np.mean(_test_ratios(found, test) ** 2) >= 1)


def _test_ratios(found: Finding, test: tuple[Prepared, ...]) -> Float[ndarray, " joints"]:
    old, new = _test_errors(found, test)
    return new / old


def _test_errors(
    found: Finding, test: tuple[Prepared, ...]
) -> tuple[Float[ndarray, " joints"], Float[ndarray, " joints"]]:
    return checked_errors(found.shop, found.selection, found.before, found.after, test)


def _found(
    shop: Workshop,
    validation: tuple[Prepared, ...],
    refused: Sequence[Refused] = (),
    *,
    upright: bool = False,
    instead_of: frozenset[Key] = frozenset(),
) -> Finding:
    """One search, without a tilt where that proves to be none."""
    turned, searched = search(shop, refused, upright=upright, instead_of=instead_of)
    declared = shop.declared.model  # as it is by itself: beside additions its signs turn otherwise
    before = fit_final(turned.declared, turned.layout_for(searched.trials), declared)
    turned, kept, after, effects = named(turned, searched, validation, before)
    if len(_names(kept)) < len(_names(searched)):
        turned, kept = kept.sharpened(turned)
        before = fit_final(turned.declared, turned.layout_for(kept.trials), declared)
        whole = with_stand_ins(turned, kept)
        turned, kept, after, effects = named(turned, whole, validation, before)
    if turned.is_turned and all(t.name != GRAVITY for t in kept.trials):
        # The tables stand as the tilt has turned them, and all that was added stands on them.
        return _found(shop, validation, kept.refused, upright=True)
    return Finding(turned, kept, before, after, effects)


def _names(selection: Selection) -> list[Trial]:
    return [t for t in selection.trials if not t.is_free_form]


def _curves(selection: Selection) -> list[Trial]:
    return [t for t in selection.trials if t.is_free_form]
