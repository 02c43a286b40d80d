"""How fast an optimiser reaches a target: histories and hit curves.

After Hansen et al. 2021, "COCO: a platform for comparing continuous optimizers in a black-box
setting".
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.optimisers.result import HistoryPoint

Resource = Literal["evaluations", "cpu_s"]
# Kept points of a history: improvements ever closer to the end, four decades of them.
KEPT_LEVELS = np.concatenate([np.geomspace(1.0, 1e-4, 30), [0.0]])


def compress(
    history: Sequence[HistoryPoint], read_at: Sequence[float] = ()
) -> tuple[HistoryPoint, ...]:
    """The points at which a history first passes levels that close in on its end.

    The first and the last finite point are always kept, so that no final value is lost.

    Args:
        history: Improvements in order.
        read_at: CPU times at which the best value so far is kept, too [s].
    """
    finite = [point for point in history if np.isfinite(point.cost)]
    if not finite:
        return ()
    first, last = finite[0].cost, finite[-1].cost
    kept = {0: finite[0]}
    index = 0
    for level in last + (first - last) * KEPT_LEVELS[1:]:
        while finite[index].cost > level:
            index += 1
        kept[index] = finite[index]
    for seconds in read_at:
        by_then = sum(point.cpu_s <= seconds for point in finite)
        if by_then:
            kept[by_then - 1] = finite[by_then - 1]
    return tuple(kept[index] for index in sorted(kept))


def cost_at(history: Sequence[HistoryPoint], resource: Resource, amount: float | int) -> float:
    """The best cost after an amount of a resource; infinite before the first point."""
    spent = [point.cost for point in history if getattr(point, resource) <= amount]
    return min(spent, default=float("inf"))


def first_hit(history: Sequence[HistoryPoint], resource: Resource, target: float) -> float:
    """What it took to reach a cost of at most `target`; infinite if it was not reached."""
    hits = [getattr(point, resource) for point in history if point.cost <= target]
    return float(min(hits, default=float("inf")))


def hit_curve(
    hits: Float[ndarray, " seeds"], amounts: Float[ndarray, " points"]
) -> Float[ndarray, " points"]:
    """Fraction of the seeds that had reached the target after each amount."""
    return (hits[:, None] <= amounts).mean(axis=0)


def expected_cost(hits: Float[ndarray, " seeds"], spent: Float[ndarray, " seeds"]) -> float:
    """Expected amount until a restarted run succeeds: all that was spent, per success.

    Args:
        hits: Amount at which each seed reached the target, infinite where it did not.
        spent: Amount that each seed spent in all.
    """
    reached = np.isfinite(hits)
    if not reached.any():
        return float("inf")
    return float(np.where(reached, hits, spent).sum() / reached.sum())


def write_history(history: Sequence[HistoryPoint]) -> str:
    """A history as one cell of a table: "evaluations:seconds:cost" joined by spaces."""
    return " ".join(f"{p.evaluations}:{p.cpu_s:.4g}:{p.cost:.7g}" for p in history)


def read_history(text: str) -> tuple[HistoryPoint, ...]:
    """Inverse of `write_history`."""
    points = [entry.split(":") for entry in text.split()]
    return tuple(HistoryPoint(int(e), float(s), float(c)) for e, s, c in points)
