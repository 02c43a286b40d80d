"""Whether a recording that is held out holds rows of one that is fitted, or plays its motion again.

The error on a copy is that of a fit, not of a prediction. That on the same motion is one of this motion:
what bends to its path foretells it, and may say nothing of another.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.checkup.finding import EvidenceRow, Finding
from oed.experiment.dataset import DataSet
from oed.experiment.paths import STEP, steps_apart
from oed.experiment.recording import Recording

# Of a column's range: a copy that was written with fewer digits is still one, and noise in two
# columns a joint leaves no two rows of different moments as near in all of them.
SAME = 1e-4
COPIED = 0.1  # of the moving rows; chance gives none
RETRACED = 0.5  # of the places of a held-out motion: most of it is no new one


def copy_finding(dataset: DataSet) -> Finding:
    """Held-out recordings whose rows, or whose motion, are also in a recording for estimation."""
    ranges = _ranges(dataset.recordings)
    rows: list[EvidenceRow] = []
    for held in (*dataset.validation, *dataset.test):
        for fitted in dataset.estimation:
            shared = copied_share(held, fitted, ranges)
            if shared > COPIED:
                rows.append(
                    {
                        "recording": held.name,
                        "role": held.role,
                        "rows of": fitted.name,
                        "copied [%]": 100 * shared,
                    }
                )
    if not rows:
        return _retracing(dataset)
    told = ", ".join(
        f"{row['recording']} ({row['role']}) has {row['copied [%]']:.3g} % of its moving rows from "
        f"{row['rows of']}"
        for row in rows
    )
    return Finding(
        "held-out recordings",
        "red",
        f"{told}: its error is that of the fit, and no prediction",
        "record another motion to be predicted",
        tuple(rows),
    )


def _retracing(dataset: DataSet) -> Finding:
    """Held-out recordings that play a fitted motion again."""
    topic, fitted = "held-out recordings", dataset.estimation
    held = (*dataset.validation, *dataset.test)
    shares = [(r, retraced_share(r, fitted)) for r in held]
    told = [
        f"{r.name} ({r.role}) follows for {100 * share:.3g} % of its way the path of the estimation "
        "recordings"
        for r, share in shares
        if share > RETRACED
    ]
    rows: tuple[EvidenceRow, ...] = tuple(
        {"recording": r.name, "role": r.role, "of a fitted path [%]": 100 * share}
        for r, share in shares
    )
    if not told:
        text = "no held-out recording holds rows of one that is fitted, or plays its motion again"
        return Finding(topic, "green", text, "", rows)
    return Finding(
        topic,
        "amber",
        f"{', '.join(told)}: its error tells of this motion, and little of another",
        "hold out a recording of another motion: oed design with another --seed gives one",
        rows,
    )


def retraced_share(held: Recording, fitted: Sequence[Recording]) -> float:
    """Share of a motion along which an arm moves where, and as, it did in others."""
    apart = steps_apart(_positions(held), [_positions(r) for r in fitted], 1 / STEP)
    moves = ~np.isnan(apart)
    return float(np.mean(apart[moves] <= 1)) if moves.any() else 0.0


def _positions(recording: Recording) -> Float[ndarray, "places joints"]:
    t = np.arange(recording.t[0], recording.t[-1], STEP)
    return np.column_stack([np.interp(t, recording.t, x) for x in recording.q.T])


def copied_share(held: Recording, fitted: Recording, ranges: Float[ndarray, " columns"]) -> float:
    """Share of one recording's moving rows that another has too, in position and torque.

    Args:
        held: Whose rows are looked for.
        fitted: In which.
        ranges: (2 n,) range of each column, q then tau, that a difference is relative to.
    """
    wanted, there = _rows(held, ranges), _rows(fitted, ranges)
    if not len(wanted) or not len(there):
        return 0.0
    known = {row.tobytes() for row in there}
    return float(np.mean([row.tobytes() in known for row in wanted]))


def _rows(recording: Recording, ranges: Float[ndarray, " columns"]) -> ndarray:
    """Rows in units of `SAME`, without those of an arm that stands."""
    columns = np.column_stack([recording.q, recording.tau])
    whole = np.round(columns / (SAME * ranges)).astype(np.int64)
    n = recording.q.shape[1]
    moves = np.any(np.diff(whole[:, :n], axis=0) != 0, axis=1)
    return np.ascontiguousarray(whole[1:][moves])


def _ranges(recordings: tuple[Recording, ...]) -> Float[ndarray, " columns"]:
    columns = np.concatenate([np.column_stack([r.q, r.tau]) for r in recordings])
    ranges = np.ptp(columns, axis=0)
    return np.where(ranges > 0, ranges, 1.0)
