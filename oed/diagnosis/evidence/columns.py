"""White columns of effects and models over all rows, without ever holding their fine samples at once."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.diagnosis.rows.white_rows import WhiteRows
from oed.dynamics.effects.effect import Effect, State
from oed.dynamics.scalars import Scalar
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepared import Prepared

SAMPLES = 20_000  # of the fine grid that a model is evaluated on at once
SETTLED = 3.0  # [s] after which a measurement has forgotten where a piece began


def white_effect(effect: Effect, model: TorqueModel, rows: WhiteRows) -> dict[int, ndarray]:
    """White columns of one effect as the model's measurement lets them be seen.

    Args:
        effect: Evaluated over whole recordings: it may remember.
        model: Gives the measurement.
        rows: Which rows.

    Returns:
        joint -> (R, k); joints on which it does not act are left out.
    """
    filtered = [_filtered(effect, model, p) for p in rows.prepared]
    acting = sorted({j for own in filtered for j in own})
    columns = len(effect.parameters)
    result = {}
    for j in acting:
        blocks = [
            own[j] if j in own else np.zeros((p.rows, columns))
            for own, p in zip(filtered, rows.prepared, strict=True)
        ]
        result[j] = rows.rows.whiten(blocks, j)
    return result


def dense(
    columns: dict[int, ndarray], rows: WhiteRows, count: int
) -> Float[ndarray, "joints rows columns"]:
    """Columns of all joints, zero where they do not act."""
    result = np.zeros((rows.joints, rows.torque.shape[1], count))
    for j, own in columns.items():
        result[j] = own
    return result


def _filtered(effect: Effect, model: TorqueModel, prepared: Prepared) -> dict[int, ndarray]:
    laps = prepared.laps if effect.beyond_state else None
    motion = prepared.motion if laps is None else laps
    if not model.measurement and laps is None:
        entries = effect.entries(State.along(motion))
        joints = {j for entry in entries for j in entry}
        return {j: _of_joint(entries, j, prepared) for j in joints}
    whole = dataclasses.replace(model, effects=(effect,)).columns(motion)
    if laps is not None:  # what changes from one repetition to the next has its own mean over them
        length = len(prepared.motion)
        whole = whole.reshape(-1, length, *whole.shape[1:]).mean(axis=0)
    acting = [j for j in range(whole.shape[1]) if whole[:, j].any()]
    return {j: prepared.band.apply(np.ascontiguousarray(whole[:, j])) for j in acting}


def _of_joint(
    entries: Sequence[Mapping[int, Scalar]], joint: int, prepared: Prepared
) -> Float[ndarray, "rows columns"]:
    fine = np.zeros((len(prepared.motion), len(entries)), order="F")
    for k, entry in enumerate(entries):
        if joint in entry:
            fine[:, k] = entry[joint]
    return prepared.band.apply(fine)


def white_model(
    model: TorqueModel, columns: Int[ndarray, " base"], rows: WhiteRows
) -> Float[ndarray, "joints rows base"]:
    """White columns of a model, a piece of each recording after another."""
    filtered = [_model_rows(model, columns, p) for p in rows.prepared]
    result = np.empty((rows.joints, rows.torque.shape[1], len(columns)))
    for j in range(rows.joints):
        result[j] = rows.rows.whiten([f[j] for f in filtered], j)
    return result


def _model_rows(
    model: TorqueModel, columns: Int[ndarray, " base"], prepared: Prepared
) -> Float[ndarray, "joints rows base"]:
    result = np.empty((model.robot.n, prepared.rows, len(columns)))
    for rows, fine, skipped in pieces(prepared, remembers=bool(model.measurement)):
        seen = prepared.band.apply(model.columns(prepared.motion[fine])[:, :, columns])
        result[:, rows] = seen[skipped : skipped + rows.stop - rows.start].transpose(1, 0, 2)
    return result


def pieces(prepared: Prepared, *, remembers: bool) -> Iterator[tuple[slice, slice, int]]:
    """Rows, the fine samples that give them, and the rows of these that come before."""
    band, rows = prepared.band, prepared.rows
    step = max(1, SAMPLES // band.factor)
    margin = int(np.ceil(SETTLED * band.analysis_rate)) if remembers else 2
    if rows <= step + margin:
        yield slice(0, rows), slice(0, len(prepared.motion)), 0
        return
    for first in range(0, rows, step):
        last = min(first + step, rows)
        begin, end = max(first - margin, 0), min(last + 2, rows)
        fine = slice(begin * band.factor, (end - 1) * band.factor + len(band.taps))
        yield slice(first, last), fine, first - begin
