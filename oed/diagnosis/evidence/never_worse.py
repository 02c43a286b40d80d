"""What of a selection foretells what it was not fitted to no worse than the base model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from oed.diagnosis.candidates.judgement import costs, rise
from oed.diagnosis.candidates.ripening import is_late
from oed.diagnosis.candidates.turning import GRAVITY
from oed.diagnosis.evidence.contradiction import held_out_rms
from oed.diagnosis.evidence.final_model import FinalModel, final_with
from oed.diagnosis.search.exchange import foretelling
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.tables.workshop import Workshop
from oed.experiment.preparation.prepared import Prepared

RAISES = "in its exact form it raises the validation error"


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


def never_worse(
    shop: Workshop,
    selection: Selection,
    validation: tuple[Prepared, ...],
    before: FinalModel,
) -> tuple[Selection, FinalModel]:
    """The augmented model in its exact form; additions that then raise the held-out error go.

    The search judges columns of first order where an effect acts on the whole model. Only the
    exact form, all parameters refitted together, can prove that nothing got worse. A late torque
    stays where it is less late and foretells more; else that addition goes without which the others
    foretell most, or all that claims no physics. What goes first may have been held down by what
    goes last: so what holds is put together from nothing, too, and what foretells most stays.
    """
    if not validation:
        return selection, final_with(shop, selection.found) if selection.trials else before
    old = held_out_rms(shop, before, validation)
    floor, counted = shop.baseline.floor.deviation, shop.unseen_full.counted

    def tried(kept: Selection) -> _Tried:
        final = final_with(shop, kept.found) if kept.trials else before
        new = held_out_rms(shop, final, validation)
        is_worse = bool(kept.trials) and costs(old, new, floor, counted)
        return _Tried(is_worse, rise(old, new, counted), kept, final)

    late = [t for t in selection.trials if is_late(t)]
    found = tried(selection)
    while found.is_worse and late:
        moved = foretelling(shop, found.kept.trials, late[0])
        found, late = tried(found.kept.exchanged(shop, late[0], moved)), late[1:]
    if found.is_worse:
        ways = (_taken_away(shop, found, tried), _built_up(shop, found, tried))
        found = min(ways, key=lambda t: (t.is_worse, t.rise))
    return found.kept, found.final


def _taken_away(shop: Workshop, found: _Tried, tried: Callable[[Selection], _Tried]) -> _Tried:
    """Additions without one after another, those gone first without which the others foretell most."""
    while found.is_worse:
        kept = found.kept
        # Without the tilt that the tables are turned by, they stay turned: it goes last.
        loose = [t for t in kept.trials if not (t.name == GRAVITY and shop.is_turned)]
        fewer = [kept.without(shop, t, RAISES) for t in reversed(loose or kept.trials)]
        # Curves that do each other's part, or a name's, are no loss one by one.
        if sum(t.is_free_form for t in loose) > 1:
            fewer.append(_without_curves(shop, kept))
        found = min(map(tried, fewer), key=lambda t: (t.is_worse, t.rise))
    return found


def _built_up(shop: Workshop, whole: _Tried, tried: Callable[[Selection], _Tried]) -> _Tried:
    """Additions one after another, on nothing or on a tilt, as long as they foretell more."""
    turned = {t.key for t in whole.kept.trials if t.name == GRAVITY and shop.is_turned}
    found = tried(whole.kept.with_only(shop, turned, RAISES))
    while True:
        kept = {t.key for t in found.kept.trials}
        more = [
            tried(whole.kept.with_only(shop, {*kept, t.key}, RAISES))
            for t in whole.kept.trials
            if t.key not in kept
        ]
        better = [m for m in more if not m.is_worse and m.rise < found.rise]
        if not better:
            return found
        found = min(better, key=lambda t: t.rise)


def _without_curves(shop: Workshop, selection: Selection) -> Selection:
    named = {t.key for t in selection.trials if not t.is_free_form}
    return selection.with_only(shop, named, RAISES)
