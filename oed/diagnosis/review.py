"""Names looked at again when all is known that stands beside them."""

from __future__ import annotations

import numpy as np

from oed.diagnosis.judgement import Accepted, Refused, share_needed
from oed.diagnosis.workshop import Workshop


def review_names(
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
            terms = [a.trial for a in free if a.trial.joint == joint]
            share = share_needed(terms, item.trial, shop.settings)
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


def drop_superfluous(
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
