"""Stretches of long recordings, spread evenly, where all rows are more than memory is to hold."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from oed.experiment.preparation.prepared import Prepared

# At least, from begin to end of all recordings; every candidate of a diagnosis is evaluated on each.
STRETCHES = 4


def excerpts(prepared: Sequence[Prepared], most: int) -> tuple[Prepared, ...]:
    """Stretches of recordings, so that no more rows than that are left.

    Recordings are cut into stretches of at most a quarter of that, of which as many are kept. Where
    motions are repeated all is kept: their mean is what is looked at, and is no longer than one.

    Args:
        prepared: Recordings.
        most: Rows of all together.
    """
    total = sum(p.rows for p in prepared)
    if total <= most or any(p.period is not None for p in prepared):
        return tuple(prepared)
    length = max(1, most // STRETCHES)
    parts = [
        (p, slice(first, min(first + length, p.rows)))
        for p in prepared
        for first in range(0, p.rows, length)
    ]
    for count in range(len(parts) - 1, 0, -1):
        kept = [parts[k * len(parts) // count] for k in range(count)]
        if sum(rows.stop - rows.start for _, rows in kept) <= most:
            return tuple(stretch(p, rows) for p, rows in kept)
    return (stretch(*parts[0]),)


def stretch(prepared: Prepared, rows: slice) -> Prepared:
    """Some rows that follow one another, and the fine samples that give them."""
    band = prepared.band
    fine = slice(rows.start * band.factor, (rows.stop - 1) * band.factor + len(band.taps))
    return dataclasses.replace(
        prepared,
        motion=prepared.motion[fine],
        fine_torque=prepared.fine_torque[fine],
        torque=prepared.torque[rows],
        t=prepared.t[rows],
        repetition=prepared.repetition[rows],
        recorded=prepared.recorded[fine],
    )
