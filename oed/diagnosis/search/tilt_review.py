"""Whether a base that is not level explains more than anything else would."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.candidates.turning import GRAVITY, far_turned, moment_fault, squares_under
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import inflation_of
from oed.diagnosis.terms.trials import Trial

# Mean squared white residual up to which a model leaves nothing for a rival to explain.
COMPLETE = 1.2


def far_tilt(shop: Workshop) -> Workshop | None:
    """The tables under a far direction of gravity, if nothing of the catalogue does as well."""
    found = far_turned(shop)
    if found is None:
        return None
    if inflation_of(found.before.fit).mean() < COMPLETE:
        return found
    gain = shop.before.fit.squares - squares_under(shop, found.baseline.model)
    best = max((s.gain for s in ranked(shop, shop.physical, (), 1)), default=0.0)
    return found if gain > best else None


def stood_upright(shop: Workshop, others: Sequence[Trial]) -> tuple[Workshop, list[Trial]]:
    """Turned tables under the gravity that was declared, with the same noise, and additions there."""
    own, _ = shop.upright.settle(others)
    return shop.upright, own


def validation_gain_of_tilt(shop: Workshop, others: Sequence[Trial]) -> float | None:
    """Share by which turned tables lower the held-out error beside other additions."""
    upright, levelled = stood_upright(shop, others)
    old = upright.validation_rms(upright.fit(levelled, bend=False))
    new = shop.validation_rms(shop.fit(others, bend=False))
    if old is None or new is None:
        return None
    return float(1 - np.sqrt(np.mean((new / old) ** 2)))


def tilt_fault(shop: Workshop, standing: list[Accepted]) -> str | None:
    """Why turned tables are no better than declared ones beside the other additions."""
    trials = [a.trial for a in standing]
    upright, levelled = stood_upright(shop, trials)
    old, new = upright.fit(levelled), shop.fit(trials)
    fault = moment_fault(shop, new.fit)
    if fault is not None:
        return fault
    chance = float(inflation_of(new.fit).mean())
    gain = (old.fit.squares - new.fit.squares) / chance
    cost = 2 * np.log(shop.full.rows.count)
    if gain < cost:
        return f"gains {gain:.3g} beside the other additions"
    lowered = validation_gain_of_tilt(shop, trials)
    if lowered is not None and lowered <= 0:
        return "beside the other additions it does not lower the validation error"
    if chance < COMPLETE:
        return None
    rows = shop.full.rows.count
    for rival in ranked(upright, upright.physical, levelled, 1):
        if rival.trial.name != GRAVITY and rival.evidence(rows) / chance > (
            gain - cost + shop.settings.decisive
        ):
            return f"{rival.trial.name} would explain more beside the other additions"
    return None
