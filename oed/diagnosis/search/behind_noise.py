"""Effects that pass for noise.

Without repetitions, noise is what a rich fit of the motion leaves, and rows of it that err
together count as few. A torque that the rich fit cannot follow, such as a load taken up on the
way, is then the noise that hides it. With repetitions, it is what these differ by, and friction
that warms up in few of them is in it. Beside the effect that it is, the noise proves to be far less.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.tables.sharpening import sharpened
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial

SLOW = 8.0  # correlated rows that count as one, from which on noise is suspected to be none
QUIETER = 0.2  # share of it that a candidate may leave, at one joint or more
TRIED = 3  # candidates
# The same of what changes between repetitions, and its gain in noise that it is part of.
LESS, NOTICED = 0.7, 20.0


def quieter_beside(
    shop: Workshop, pool: Sequence[Trial], others: Sequence[Trial]
) -> Iterator[tuple[Workshop, Trial]]:
    """Candidates that much of the noise may be, each with the tables as they are beside it.

    Args:
        shop: The laid-out data.
        pool: Candidates, over the grids of their shapes.
        others: Additions.
    """
    repeated = shop.mean is not shop.full
    suspects = _changing(shop, pool, others) if repeated else _slow(shop, pool, others)
    for trial in suspects:
        beside = sharpened(shop, [*others, trial])
        left = LESS if repeated else QUIETER
        if beside is None:
            continue
        if np.any((_loudness(beside) < left * _loudness(shop))[list(trial.group)]):
            yield beside, trial


def _slow(shop: Workshop, pool: Sequence[Trial], others: Sequence[Trial]) -> list[Trial]:
    """What acts where noise changes slowly."""
    slow = np.flatnonzero(shop.baseline.floor.dilution > SLOW)
    if not len(slow):
        return []
    found = ranked(shop, pool, others, shop.settings.refined, thorough=True)
    acting = [s for s in found if not set(slow).isdisjoint(s.trial.group)]
    return [s.trial for s in sorted(acting, key=lambda s: -s.gain)[:TRIED]]


def _changing(shop: Workshop, pool: Sequence[Trial], others: Sequence[Trial]) -> list[Trial]:
    """What changes from one repetition to the next; whitened noise would hide its own colour."""
    keys = {t.key for t in pool if t.between_repetitions}
    plain = shop.on(dataclasses.replace(shop.baseline, floor=shop.baseline.floor.uncoloured))
    places = dict.fromkeys((t.name, t.target) for t in pool if t.key in keys)
    own = [t for place in places for t in plain.candidates(*place)]
    if not own:
        return []
    found = ranked(plain, own, [plain.renewed(t) for t in others], shop.settings.refined)
    return [shop.renewed(s.trial) for s in found if s.gain > NOTICED][:TRIED]


def _loudness(shop: Workshop) -> Float[ndarray, " joints"]:
    """(n,) noise of a mean over as many rows, in units of a white one's [N m]."""
    floor = shop.baseline.floor
    return floor.deviation * np.sqrt(floor.dilution)
