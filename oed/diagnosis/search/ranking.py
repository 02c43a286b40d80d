"""Candidates in the order of their evidence, their shapes refined."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.diagnosis.fit.linear_fit import LinearFit
from oed.diagnosis.search.ripening import has_crests, is_late, is_unripe, ripened, searched
from oed.diagnosis.search.scan import Score, refine, scan, score
from oed.diagnosis.search.turning import NAME as GRAVITY
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.terms.trials import Trial

OF_EACH = 2  # candidates of every joint that are refined in any case
LATE_SHARE = 0.2  # of the best gain, from which on a late torque is worth evaluating anew
PROMISING = 0.4  # of the best gain, from which on what a gear promises is worth it
CONTENDING = 0.5  # of the best gain, from which on it is worth a wide search


def ranked(
    shop: Workshop,
    pool: Sequence[Trial],
    others: Sequence[Trial],
    most: int,
    *,
    thorough: bool = False,
) -> list[Score]:
    """Refined candidates beside some additions, best evidence first.

    Args:
        shop: The laid-out data.
        pool: Candidates, over the grids of their shapes.
        others: Additions.
        most: Candidates that are refined.
        thorough: Whether the best ones of every joint are among those refined, since what one
            joint lacks may outshine all that the others do, and those that act on a joint's own
            torque are evaluated on what they leave; a delay and a lag always are, since little
            else tells them apart.
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
        scores = scan(part, fit, shop.context)
        # By surprise for the small effect of a quiet joint, by gain for the large one that
        # makes its joint's residual loud.
        leading = scores[:most] + sorted(scores, key=lambda s: -s.gain)[:most]
        if thorough:
            leading += _best_of_each_joint(scores)
        leading = {s.trial.key: s for s in leading}
        refined = [refine(s, fit, shop.context) for s in leading.values()]
        best = max(s.gain for s in refined)
        green = [
            s
            for s in refined
            if is_late(s.trial) and s.gain > LATE_SHARE * best and s.evidence(rows) > 0
        ]
        if thorough:
            gears = {s.trial.key: s for s in _unripe(part, fit)}
            gears |= {s.trial.key: s for s in refined if is_unripe(s.trial)}
            hopeful = [
                s
                for s in gears.values()
                if s.promise > max(PROMISING * best, s.freedom * np.log(rows))
            ]
            refined += [s for s in hopeful if s.trial.key not in leading]
            green += hopeful
        ripe = {
            s.trial.key: ripened(shop, [t for t in part if t.key == s.trial.key], others, fit)
            for s in green
        }
        refined = [ripe.get(s.trial.key, s) for s in refined]
        contending = CONTENDING * max(s.gain for s in refined)
        found += [
            searched(shop, s, others, fit)
            if thorough and has_crests(s) and s.gain > contending
            else s
            for s in refined
        ]
    return sorted(found, key=lambda s: -s.evidence(rows))


def _unripe(part: Sequence[Trial], fit: LinearFit) -> list[Score]:
    """The most promising shape of every candidate that acts on a joint's own torque."""
    best: dict[tuple[str, object], Score] = {}
    for trial in part:
        if is_unripe(trial):
            found = score(trial, fit.projection, fit.residual)
            best[trial.key] = max(best.get(trial.key, found), found, key=lambda s: s.promise)
    return list(best.values())


def _best_of_each_joint(scores: Sequence[Score]) -> list[Score]:
    """The first few of every joint, in the order in which they come."""
    found: dict[int | None, list[Score]] = {}
    for s in scores:
        found.setdefault(s.trial.joint, []).append(s)
    return [s for own in found.values() for s in own[:OF_EACH]]
