"""Whether names are right as often as the diagnosis says that they are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from studies.bench.rates import BenchRow, Rate, done

# A name is reported from 0.95; ambiguous ones have less. Between the others a wrong one in a
# hundred, a thousand, or fewer is stated.
EDGES = (0.0, 0.95, 0.99, 0.999, 1.0)
RIGHT, WRONG = "right", "wrong"


def stated_text(stated: Sequence[tuple[float, bool]]) -> str:
    """Probabilities of names and whether these are right, as a cell of the bench's lines."""
    return " ".join(f"{p:.6g}:{RIGHT if is_right else WRONG}" for p, is_right in stated)


def reliability(rows: Sequence[BenchRow]) -> list[dict[str, float | int | str]]:
    """How often names are right, by the probability that was stated for them.

    A name counts as right where a hidden effect accounts for it: as itself, a delay for a lag, or one
    of the rivals that the verdict leaves open.
    """
    claims = list(_stated(done(rows)))
    table: list[dict[str, float | int | str]] = []
    for low, high in pairwise(EDGES):
        inside = [own for own in claims if low <= own[0] < high or own[0] == high == EDGES[-1]]
        if not inside:
            continue
        found = Rate(sum(is_right for _, is_right in inside), len(inside))
        lower, upper = found.interval
        table.append(
            {
                "from": low,
                "to": high,
                "names": len(inside),
                "stated": float(np.mean([p for p, _ in inside])),
                "right": found.hits / found.cases,
                "lower": lower,
                "upper": upper,
            }
        )
    return table


def _stated(rows: Sequence[BenchRow]) -> Iterator[tuple[float, bool]]:
    for row in rows:
        for cell in row["stated"].split():
            probability, _, word = cell.partition(":")
            yield float(probability), word == RIGHT
