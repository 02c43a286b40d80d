"""Effects that pass for noise.

Without repetitions, noise is what a rich fit of the motion leaves, and rows of it that err
together count as few. A torque that the rich fit cannot follow, such as a load taken up on the
way, is then the noise that hides it. Beside the effect that it is, the noise proves to be far less.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.search.ranking import ranked
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.terms.trials import Trial

SLOW = 8.0  # correlated rows that count as one, from which on noise is suspected to be none
QUIETER = 0.2  # share of it that a candidate may leave, at one joint or more
TRIED = 3  # candidates


def quieter_beside(
    shop: Workshop, pool: Sequence[Trial], others: Sequence[Trial]
) -> Iterator[tuple[Workshop, Trial]]:
    """Candidates that much of the noise may be, each with the tables as they are beside it.

    Args:
        shop: The laid-out data.
        pool: Candidates, over the grids of their shapes.
        others: Additions.
    """
    slow = np.flatnonzero(shop.baseline.floor.dilution > SLOW)
    if not len(slow):
        return
    found = ranked(shop, pool, others, shop.settings.refined, thorough=True)
    acting = [s for s in found if not set(slow).isdisjoint(s.trial.group)]
    for candidate in sorted(acting, key=lambda s: -s.gain)[:TRIED]:
        beside = shop.sharpened([*others, candidate.trial])
        if beside is not None and np.any((_loudness(beside) < QUIETER * _loudness(shop))[slow]):
            yield beside, candidate.trial


def _loudness(shop: Workshop) -> Float[ndarray, " joints"]:
    """(n,) noise of a mean over as many rows, in units of a white one's [N m]."""
    floor = shop.baseline.floor
    return floor.deviation * np.sqrt(floor.dilution)
