"""What is fitted beside every model and belongs to none: reversals, and noise that moves the arm."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.numbers import NOISE_LAGS
from oed.diagnosis.rows.white_rows import WhiteRows
from oed.dynamics.effects.catalogue import Context
from oed.estimation.noise_floor.linear_fit import reversal_nuisances
from oed.experiment.preparation.motion_band import search_cutoff
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.recording import Recording
from oed.experiment.signals.lowpass import lowpass


def nuisances(
    rows: WhiteRows, context: Context, recordings: Sequence[Recording], *, repeated: bool
) -> Float[ndarray, "joints rows nuisances"]:
    """White columns of all nuisances.

    Args:
        rows: Of recordings, or of the means of repetitions.
        context: Gives the torque.
        recordings: For estimation; their spectrum gives the band of the motion.
        repeated: Whether repetitions of a motion tell noise from what is alike in all.
    """
    reversals = reversal_nuisances(rows.rows)
    if repeated:
        return reversals
    return np.concatenate([reversals, _motion_noise(rows, context, recordings)], axis=2)


def _motion_noise(
    rows: WhiteRows, context: Context, recordings: Sequence[Recording]
) -> Float[ndarray, "joints rows nuisances"]:
    """What motion beyond its own band makes: torque of the rigid body, and the controller's answer.

    What shakes the arm shows in its torque and in its motion, so that what a model leaves goes
    together with the motion: a lag or a spring in a drive would explain it. The controller answers
    by position, later or sooner, hence the lags. Where motions repeat, their differences show it.
    """
    joints = rows.joints
    rate = rows.prepared[0].band.rate
    shortest = min(float(np.ptp(p.motion.t)) for p in rows.prepared)
    edge = search_cutoff(tuple(recordings), rate, shortest).band_edge
    fine = [_shaken(p, context, edge) for p in rows.prepared]
    count = fine[0].shape[2]
    result = np.zeros((joints, rows.torque.shape[1], count * joints))
    for j in range(joints):
        result[j, :, count * j : count * (j + 1)] = rows.whiten([f[:, j] for f in fine], j)
    return result


def _shaken(
    prepared: Prepared, context: Context, edge: float
) -> Float[ndarray, "samples joints lags"]:
    motion, rate = prepared.motion, prepared.band.rate
    slow = dataclasses.replace(motion, ddq=lowpass(motion.ddq, rate, edge))
    torque = (context.reference.parts(motion) - context.reference.parts(slow)).sum(axis=2)
    position = motion.q - lowpass(motion.q, rate, edge)
    step = max(1, round(rate / (NOISE_LAGS * prepared.band.cutoff)))
    lags = range(-(NOISE_LAGS // 2), NOISE_LAGS // 2 + 1)
    return np.stack(
        [np.roll(signal, k * step, axis=0) for signal in (torque, position) for k in lags], axis=2
    )
