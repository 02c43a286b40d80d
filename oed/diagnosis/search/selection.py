"""Which additions stay: competition, exchange, multiplicity, held-out gain, plausibility."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.diagnosis.candidates.accepted import Accepted, Refused, at_home, refusal
from oed.diagnosis.candidates.judgement import WORSE
from oed.diagnosis.candidates.pickups import take_up_again
from oed.diagnosis.candidates.turning import accepted_tilt, turned, turned_beside
from oed.diagnosis.search.exchange import decided_shapes, rested
from oed.diagnosis.search.name_search import NameSearch
from oed.diagnosis.search.review import drop_needless, drop_superfluous, review_names
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.search.standing_in import next_free_form
from oed.diagnosis.search.tilt_review import far_tilt, tilt_fault
from oed.diagnosis.tables.workshop import Workshop

FAR_LESS = 0.5  # of a squared error


def search(
    shop: Workshop,
    refused: Sequence[Refused] = (),
    *,
    upright: bool = False,
    instead_of: frozenset[tuple[str, object]] = frozenset(),
) -> tuple[Workshop, Selection]:
    """Add, exchange and drop until nothing passes all tests; the tables may be made anew.

    Args:
        shop: The laid-out data.
        refused: What an earlier search turned down.
        upright: Whether no tilt may be named.
        instead_of: Keys of names that a tilt is put in the place of, to begin with.
    """
    refused = list(refused)
    start = shop if upright else ((turned(shop, ()) if instead_of else far_tilt(shop)) or shop)
    names = NameSearch(start, refused, upright=upright, barred=set(instead_of))
    found, accepted = _added(names)
    tilts = []
    if found.is_turned:
        tilt = accepted_tilt(found, shop)
        fault = tilt_fault(found, [a for a in accepted if a.stands_in])
        if fault is None:
            tilts = [tilt]
        else:
            refused.append(refusal(tilt, fault))
            anew = NameSearch(shop, refused, upright=True, barred=set(instead_of))
            found, accepted = _added(names.before_tilt() or anew)
    return _concluded(found, accepted, refused, tilts)


def with_stand_ins(shop: Workshop, selection: Selection) -> Selection:
    """The names of a selection, and free-form terms anew for what they leave.

    Some were found beside names that fell since, and do not do what these did.

    Args:
        shop: The tables that the selection stands on.
        selection: With the names that are left.
    """
    refused = list(selection.refused)
    names = [a for a in selection.accepted if not a.trial.is_free_form]
    whole = drop_needless(shop, _with_free_forms(shop, names, refused), refused)
    return Selection.of(shop, whole, refused)


def _added(state: NameSearch) -> tuple[Workshop, list[Accepted]]:
    """Named effects, then free-form terms.

    Where a free-form term makes a name superfluous, others that it kept out have their turn.
    """
    refused, given_up = state.refused, []
    while True:
        state.add_names()
        unreviewed = _with_free_forms(state.shop, state.accepted, refused)
        if state.sharpen(unreviewed):
            continue
        whole = review_names(state.shop, unreviewed, refused)
        names = [a for a in whole if not a.trial.is_free_form]
        fallen = {a.trial.key for a in state.accepted} - {a.trial.key for a in names}
        if not fallen:
            break
        given_up.append((state.shop, unreviewed))
        state.give_up(fallen, names)
    shop, whole = _foretelling_most([(state.shop, whole), *given_up])
    if shop.is_turned:
        shop, whole = turned_beside(shop, whole)
    return shop, whole


def _foretelling_most(
    found: Sequence[tuple[Workshop, list[Accepted]]],
) -> tuple[Workshop, list[Accepted]]:
    """What was found at last, unless names that fell foretold far more.

    What made them superfluous may not be found without them.
    """
    errors = [_unseen_error(*f) for f in found]
    best = int(np.argmin(errors))
    return found[best] if errors[best] < FAR_LESS * errors[0] else found[0]


def _unseen_error(shop: Workshop, whole: Sequence[Accepted]) -> float:
    return shop.unseen_error([a.trial for a in whole if a.stands_in])


def _with_free_forms(
    shop: Workshop, names: list[Accepted], refused: list[Refused]
) -> list[Accepted]:
    """Names, and what stands in for the rest."""
    accepted = list(names)
    for _ in range(shop.settings.most_free_forms(shop.context.n)):
        pick = next_free_form(shop, accepted, refused)
        if pick is None:
            break
        accepted.append(pick)
    return accepted


def _concluded(
    shop: Workshop, accepted: list[Accepted], refused: list[Refused], tilts: list[Accepted]
) -> tuple[Workshop, Selection]:
    needed = drop_needless(shop, [*tilts, *accepted], refused)[len(tilts) :]
    # At the shape that one motion alone prefers, a name may foretell another worse than none.
    needed = drop_superfluous(shop, decided_shapes(shop, needed), refused)
    if tilts and len(needed) < len(accepted):  # what fell had its part in the tilt
        other, left = turned_beside(shop, needed)
        # Moments that no link has may have done in its place what it does.
        if _unseen_error(other, left) > WORSE**2 * _unseen_error(shop, accepted):
            needed = accepted
        else:
            shop, needed = other, left
        tilts = [at_home(shop, tilt) for tilt in tilts]
    take_up_again(shop, [a.trial for a in needed if a.stands_in])
    accepted = decided_shapes(shop, rested(shop, [*tilts, *needed]))
    return shop, Selection.of(shop, accepted, refused)
