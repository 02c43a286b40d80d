"""What the steps of an encoder do to the torque residual.

A quantised position errs in the same way each time the same motion is run: the error is no
lack of the model, and no pure error either.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.fit.rows import Rows
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.recording import Recording
from oed.experiment.signals.differentiation import central_difference
from oed.experiment.signals.lowpass import lowpass

ON_GRID = 0.98  # share of the logged positions that must be multiples of a step
TOLERANCE = 0.02  # of a step


def encoder_steps(recordings: Sequence[Recording]) -> Float[ndarray, " joints"]:
    """(n,) smallest step of each joint's logged positions [rad]; 0 where there is none."""
    joints = recordings[0].n
    steps = np.zeros(joints)
    for j in range(joints):
        changes = np.abs(np.concatenate([np.diff(r.q[:, j]) for r in recordings]))
        moved = changes[changes > 0]
        if len(moved) == 0:
            continue
        step = float(np.quantile(moved, 0.02))
        near = moved[moved < 1.5 * step]
        step = float(np.median(near))
        off = np.abs(moved / step - np.round(moved / step))
        # Rounding of the digits in a file is a grid too, but so fine that it means nothing.
        if np.mean(off < TOLERANCE * np.maximum(np.round(moved / step), 1)) > ON_GRID:
            steps[j] = step
    return steps


def rounding_squares(
    model: TorqueModel,
    parameters: Float[ndarray, " parameters"],
    rows: Rows,
    steps: Float[ndarray, " joints"],
) -> Float[ndarray, " joints"]:
    """(n,) mean square that these steps add to a row of the white residual."""
    joints = len(steps)
    if not np.any(steps > 0):
        return np.zeros(joints)
    errors = []
    for p in rows.prepared:
        rounded = p.motion.q.copy()
        has_steps = steps > 0
        rounded[:, has_steps] = (
            np.round(rounded[:, has_steps] / steps[has_steps]) * steps[has_steps]
        )
        change = lowpass(rounded - p.motion.q, p.band.rate, p.band.smoothing)
        rate = central_difference(change, p.band.rate)
        there = dataclasses.replace(
            p.motion,
            q=p.motion.q + change,
            dq=p.motion.dq + rate,
            ddq=p.motion.ddq + central_difference(rate, p.band.rate),
        )
        difference = model.torque(parameters, there) - model.torque(parameters, p.motion)
        errors.append(p.band.apply(difference))
    squares = np.zeros(joints)
    for j in range(joints):
        white = rows.whiten([e[:, [j]] for e in errors], j)
        squares[j] = np.sum(white**2) / max(float(np.sum(rows.weights[:, j] ** 2)), 1.0)
    return squares
