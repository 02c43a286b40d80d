"""The motion that tells most of what the recordings at hand leave in doubt.

An effect that explains a little more than chance may be there, too small to be named where the arm
has been: friction that falls at speeds which a motion crosses in no time. Its information is the
squared white torque, at the size that the data have for it, which no base parameters reproduce. The
next motion is the one that multiplies this most, over the effects in doubt (the D-criterion of each
alone; Fedorov 1972, "Theory of Optimal Experiments").
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.rivals.favourite import torque_on, with_further
from oed.diagnosis.rivals.motions import as_prepared, random_motions
from oed.diagnosis.tables.workbench import Layout
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import Score, implausible, scan
from oed.diagnosis.terms.trials import Trial
from oed.dynamics.motion import Motion

IN_DOUBT = 5  # effects, those that surprise most


@dataclass(frozen=True)
class Exposing:
    """A motion, and what it is to show.

    Attributes:
        motion: One period on the fine grid.
        doubted: The effects, the most surprising first.
        gain: Factor of their information, the geometric mean over them.
    """

    motion: Motion
    doubted: tuple[Trial, ...]
    gain: float


def design_exposing(
    shop: Workshop, chosen: Sequence[Trial], rng: np.random.Generator, *, candidates: int = 48
) -> Exposing | None:
    """The best of a number of random motions within the limits; None if no effect is in doubt.

    Args:
        shop: The data at hand.
        chosen: What was found in them.
        rng: Draws motions.
        candidates: Motions to compare.
    """
    doubted = _in_doubt(shop, chosen)
    if not doubted:
        return None
    pattern = shop.mean.rows.prepared[0]
    motions, _ = random_motions(shop.baseline.model.robot, pattern, rng, candidates)

    def told(layout: Layout) -> Float[ndarray, " doubted"]:
        fits = (torque_on(shop, layout, s.trial, s.coefficients) for s in doubted)
        return np.array([fit.squares for fit in fits])

    known = told(shop.mean)
    layouts = (with_further(shop, shop.mean, as_prepared(pattern, m)) for m in motions)
    gains = [float(np.exp(np.mean(np.log(told(layout) / known)))) for layout in layouts]
    best = int(np.argmax(gains))
    return Exposing(motions[best], tuple(s.trial for s in doubted), gains[best])


def _in_doubt(shop: Workshop, chosen: Sequence[Trial]) -> list[Score]:
    """Plausible effects that explain something beside what was found, the most surprising first."""
    taken = {t.key for t in chosen}
    pool = [
        t for t in shop.physical if t.key not in taken and not t.fixed and not t.between_repetitions
    ]
    found = scan(pool, shop.fit(chosen, shop.mean).fit, shop.context)
    told = [s for s in found if s.gain > 0 and implausible(s, shop.context) is None]
    return told[:IN_DOUBT]
