"""Candidates in the order of their evidence, their shapes refined."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.diagnosis.candidates.clocks import by_other_clock
from oed.diagnosis.candidates.ripening import (
    has_crests,
    is_late,
    is_part_of,
    is_unripe,
    ripened,
    searched,
    where_it_ended,
)
from oed.diagnosis.candidates.turning import GRAVITY
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import refine
from oed.diagnosis.terms.scores import Score, best_shapes, score, scores
from oed.diagnosis.terms.trials import Trial, moved
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.parallel_map import side_by_side

OF_EACH = 2  # candidates of every joint that are refined in any case
LATE_SHARE = 0.2  # of the best gain, from which on a late torque is worth evaluating anew
PROMISING = 0.3  # of the best gain, from which on what a gear promises is worth it
CONTENDING = 0.5  # of the best gain, from which on it is worth a wide search


def ranked(
    shop: Workshop,
    pool: Sequence[Trial],
    others: Sequence[Trial],
    most: int,
    *,
    thorough: bool = False,
    least: float = -np.inf,
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
        least: Gain below which a candidate is left as it is on its grid.
    """
    keys = {t.key for t in others}
    if shop.is_turned:
        pool = [t for t in pool if t.name != GRAVITY]
    found: list[Score] = []
    for between in (False, True):
        part = [t for t in pool if t.between_repetitions == between and t.key not in keys]
        if part:
            fit = shop.fit(others, shop.full if between else shop.mean).fit
            grid = scores(part, fit)
            leading = _leading(shop, grid, fit, most, thorough=thorough, least=least)
            refined = [_on_its_clock(shop, s, others, fit) for s in leading]
            found += _evaluated(shop, grid, refined, others, fit, thorough=thorough, least=least)
    rows = shop.full.rows.count
    return sorted(found, key=lambda s: -s.evidence(rows))


def _leading(
    shop: Workshop,
    grid: Sequence[Score],
    fit: LinearFit,
    most: int,
    *,
    thorough: bool,
    least: float,
) -> list[Score]:
    """The leading candidates at the best of their shapes."""
    best = best_shapes(grid, fit, shop.context)
    # By surprise for the small effect of a quiet joint, by gain for the large one that
    # makes its joint's residual loud.
    leading = best[:most] + sorted(best, key=lambda s: -s.gain)[:most]
    if thorough:
        leading += _best_of_each_joint(best)

    def refined(found: Score) -> Score:
        if found.gain < least:
            return found
        return _within_recordings(shop, refine(found, fit, shop.context), grid, fit)

    return side_by_side(refined, list(_by_key(leading).values()))


def _within_recordings(
    shop: Workshop, found: Score, grid: Sequence[Score], fit: LinearFit
) -> Score:
    """A change in the pause between recordings, or the one within a recording that explains more.

    The pause is judged by all that recordings differ by, the other by what repetitions differ by:
    only on the same columns can their gains be compared.
    """
    own = [s for s in grid if s.trial.key == found.trial.key and s.trial.contrast]
    if found.trial.contrast or not own:
        return found
    inside = max(own, key=lambda s: s.gain)
    whole = moved(inside.trial, fit.rows, shop.context)
    level = refine(score(whole, fit), fit, shop.context)
    if level.gain <= found.gain + shop.settings.decisive:
        return found
    return refine(inside, fit, shop.context)


def _on_its_clock(shop: Workshop, found: Score, others: Sequence[Trial], fit: LinearFit) -> Score:
    """A change in time by the clock that the validation recordings go by."""
    if not shop.validation:
        return found
    turned = by_other_clock(shop, found.trial)
    if turned is None:
        return found
    tried = [found, score(turned, fit)]
    return min(tried, key=lambda s: shop.unseen_error([*others, s.trial]))


def _evaluated(
    shop: Workshop,
    grid: Sequence[Score],
    refined: Sequence[Score],
    others: Sequence[Trial],
    fit: LinearFit,
    *,
    thorough: bool,
    least: float,
) -> list[Score]:
    """Refined candidates, and gears that promise as much, on the torque that they leave."""
    rows, best = shop.full.rows.count, max(s.gain for s in refined)
    found = _by_key(refined)
    green = [
        s
        for s in refined
        if is_late(s.trial) and s.gain > max(LATE_SHARE * best, least) and s.evidence(rows) > 0
    ]
    gears = []
    if thorough:
        promising = (
            s
            for s in (*grid, *refined)
            if is_unripe(s.trial) and s.promise > max(PROMISING * best, s.freedom * np.log(rows))
        )
        gears = list(_by_key(sorted(promising, key=lambda s: s.promise)).values())
    own = [[g for g in grid if g.trial.key == s.trial.key] for s in (*green, *gears)]
    found |= _by_key(side_by_side(lambda points: ripened(shop, points, others, fit), own))
    best = max(s.gain for s in found.values())
    # Of what a grid point promises, a simplex from there may find nothing.
    ripe = [(found[gear.trial.key], gear.promise) for gear in gears]
    wide = [
        s for s, promise in ripe if has_crests(s) and (s.gain > CONTENDING * best or promise > best)
    ]
    found |= _by_key(side_by_side(lambda s: searched(shop, s, others, fit), wide))
    for plain in _plainer(shop, grid, list(found.values()), others, fit):
        key = plain.trial.key
        found[key] = max(found.get(key, plain), plain, key=lambda s: s.gain)
    return list(found.values())


def _plainer(
    shop: Workshop,
    grid: Sequence[Score],
    found: Sequence[Score],
    others: Sequence[Trial],
    fit: LinearFit,
) -> list[Score]:
    """Gears that are part of those found, from where these ended.

    A spring may miss by its own grid what it explains, and a gap that adds nothing to it be named.
    """
    gears = [s for s in found if is_unripe(s.trial) and s.gain > 0]
    trials = {s.trial.key: s.trial for s in grid}.values()
    return [
        where_it_ended(shop, gear, plain, others, fit)
        for gear in gears
        for plain in trials
        if is_part_of(plain, gear.trial)
    ]


def _by_key(scores: Sequence[Score]) -> dict[tuple[str, object], Score]:
    """One score of every candidate, the last that there is."""
    return {s.trial.key: s for s in scores}


def _best_of_each_joint(scores: Sequence[Score]) -> list[Score]:
    """The first few of every joint, in the order in which they come."""
    found: dict[int | None, list[Score]] = {}
    for s in scores:
        found.setdefault(s.trial.joint, []).append(s)
    return [s for own in found.values() for s in own[:OF_EACH]]
