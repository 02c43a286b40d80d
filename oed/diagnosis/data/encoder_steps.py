"""What the steps of an encoder do to the torque residual.

A quantised position errs in the same way each time the same motion is run: the error is no
lack of the model, and what repetitions differ by does not show it. Torques of an acceleration
err the more the faster the change: where an encoder is coarse, that drowns the upper part of the
band.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.data.prepared import Prepared
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.recording import Recording

ON_GRID = 0.98  # share of the logged positions that must be multiples of a step
TOLERANCE = 0.02  # of a step
FEW = 10  # steps, of which one can tell how many they are
SEED = 0  # of the errors drawn
# Shares of the changes among which a single step is looked for, the coarsest grid first: a joint
# that moves fast seldom moves by as little.
RARE = (0.02, 0.002, 0.0)


def encoder_steps(recordings: Sequence[Recording]) -> Float[ndarray, " joints"]:
    """(n,) smallest step of each joint's logged positions [rad]; 0 where there is none."""
    joints = recordings[0].n
    steps = np.zeros(joints)
    for j in range(joints):
        changes = np.abs(np.concatenate([np.diff(r.q[:, j]) for r in recordings]))
        moved = changes[changes > 0]
        if len(moved) == 0:
            continue
        guesses = (_near(moved, float(np.quantile(moved, share))) for share in RARE)
        steps[j] = next((step for step in guesses if _is_grid(moved, step)), 0.0)
    return steps


def _near(moved: Float[ndarray, " changes"], guess: float) -> float:
    """Median of the changes of about that size: digits of a file spread them."""
    return float(np.median(moved[moved < 1.5 * guess]))


def _is_grid(moved: Float[ndarray, " changes"], step: float) -> bool:
    # Many steps are a multiple of anything, near enough.
    steps = moved[moved < FEW * step] / step
    count = np.round(steps)
    return bool(np.mean(np.abs(steps - count) < TOLERANCE * np.maximum(count, 1)) > ON_GRID)


def repeated_steps(recordings: Sequence[Recording]) -> Float[ndarray, " joints"]:
    """(n,) encoder steps whose rounding repeats with the motion [rad].

    Each is as small as the part of its error that comes again: that of two positions d steps
    apart correlates by 1 - 6 d for small d, and d is the share of the samples that differ. Where
    repetitions differ by more than that, and without any, the noise has it all.
    """
    steps = encoder_steps(recordings)
    share = np.zeros(len(steps))
    compared = 0
    for recording in recordings:
        period = recording.period
        if period is None or recording.repetitions < 2:
            continue
        turn = round(period / float(np.median(np.diff(recording.t))))
        change = np.abs(recording.q[turn:] - recording.q[:-turn])
        share += len(change) * np.clip(1 - 6 * np.mean(change > steps / 2, axis=0), 0.0, 1.0)
        compared += len(change)
    return steps * np.sqrt(share / max(compared, 1))


def rounding_deviation(steps: Float[ndarray, " joints"]) -> Float[ndarray, " joints"]:
    """(n,) standard deviation of what rounding to steps errs."""
    return steps / np.sqrt(12)


def encoder_torque(
    model: TorqueModel,
    parameters: Float[ndarray, " parameters"],
    prepared: Sequence[Prepared],
    deviations: Sequence[Float[ndarray, " joints"]] | None = None,
) -> list[Float[ndarray, "rows joints"]]:
    """Errors of the predicted torque as errors of the encoders make them, in the band [N m].

    An error is drawn evenly over a step: which one a sample met is not to be told any more from
    positions that were smoothed after it.

    Args:
        model: Whose torque.
        parameters: Of it.
        prepared: Recordings.
        deviations: (n,) of each one's encoders [rad]; of the rounding that comes again in every
            repetition if None.
    """
    rng = np.random.default_rng(SEED)
    if deviations is None:
        deviations = [rounding_deviation(p.repeated_steps) for p in prepared]
    errors = []
    for p, deviation in zip(prepared, deviations, strict=True):
        rounded = deviation * rng.uniform(-np.sqrt(3), np.sqrt(3), p.motion.q.shape)
        if not deviation.any():
            errors.append(np.zeros_like(p.torque))
            continue
        change, rate, acceleration = p.band.differentiate(rounded)
        there = dataclasses.replace(
            p.motion,
            q=p.motion.q + change,
            dq=p.motion.dq + rate,
            ddq=p.motion.ddq + acceleration,
        )
        difference = model.torque(parameters, there) - model.torque(parameters, p.motion)
        errors.append(p.band.apply(difference))
    return errors
