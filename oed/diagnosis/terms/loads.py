"""Columns of a load that comes and goes, filtered once for all its moments.

A load is the same columns whenever it is taken up. But for the few windows of the filter in which
it comes, a row has all of them or none: a search for the moment need not filter them again.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis_new.rows.model_columns import effect_columns
from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.dynamics.effects.payload import PayloadChange
from oed.experiment.preparation.band import Band
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.signals.moving_sum import windows

Columns = tuple[Float[ndarray, "samples columns"], Float[ndarray, "rows columns"]]


def white_load(
    effect: PayloadChange, rows: Rows, *, contrast: bool
) -> dict[int, Float[ndarray, "rows columns"]]:
    """White columns of a load, joint by joint.

    Args:
        effect: The load and its moment.
        rows: Where.
        contrast: Whether to keep only what differs between repetitions of one phase.
    """
    whole = rows.remembered.get(
        (effect.robot, effect.link, effect.kept, contrast),
        lambda: [_throughout(effect, p, contrast=contrast) for p in rows.prepared],
    )
    parts = [_held_share(effect, p, contrast=contrast) for p in rows.prepared]
    return {
        joint: rows.whiten(
            [
                _partly(own[joint], held, p.band)
                for own, held, p in zip(whole, parts, rows.prepared, strict=True)
            ],
            joint,
        )
        for joint in sorted(whole[0])
    }


def _throughout(effect: PayloadChange, prepared: Prepared, *, contrast: bool) -> dict[int, Columns]:
    """Columns of a load that is held all the time, by joint: fine ones, and rows of the band."""
    motion = prepared.mean_motion if contrast else prepared.motion
    fine = effect_columns(effect.throughout(), motion, 0.0)
    return {joint: (block, prepared.band.apply(block)) for joint, block in fine.items()}


def _held_share(
    effect: PayloadChange, prepared: Prepared, *, contrast: bool
) -> Float[ndarray, " samples"]:
    """What of a load each fine sample has; less its mean over the repetitions of the phase."""
    held = effect.held(prepared.motion.t)
    if not contrast or prepared.period is None:
        return held
    return held - prepared.phase_mean(held[:, None])[:, 0]


def _partly(
    columns: Columns,
    share: Float[ndarray, " samples"],
    band: Band,
) -> Float[ndarray, "rows columns"]:
    """Filtered columns times a share that changes at a few samples."""
    (fine, filtered), window = columns, len(band.taps)
    starts = np.arange(len(filtered)) * band.factor
    changes = np.flatnonzero(share[1:] != share[:-1])
    result = filtered * share[starts, None]
    if not len(changes):
        return result
    until = np.searchsorted(changes, starts + window - 1)
    mixed = np.flatnonzero(until > np.searchsorted(changes, starts))
    weights = windows(share, window, band.factor)[mixed] * band.taps
    held = windows(fine, window, band.factor)[mixed]
    result[mixed] = np.einsum("rw,rcw->rc", weights, held)
    return result
