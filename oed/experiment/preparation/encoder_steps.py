"""What the steps of an encoder do to the torque residual.

A quantised position errs in the same way each time the same motion is run: the error is no
lack of the model, and what repetitions differ by does not show it. Torques of an acceleration
err the more the faster the change: where an encoder is coarse, that drowns the upper part of the
band.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from oed.dynamics.motion import Motion
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.recording import Recording

Torque = Callable[[Motion], Float[ndarray, "samples joints"]]
ON_GRID = 0.98  # share of the logged positions that must be multiples of a step
TOLERANCE = 0.02  # of a step
FEW = 10  # steps, of which one can tell how many they are
SEED = 0  # of the errors drawn
# Shares of the changes among which a single step is looked for, the coarsest grid first: a joint
# that moves fast seldom moves by as little.
RARE = (0.02, 0.002, 0.0)
MOVING = 0.1  # [s] within which a joint that moves does so by a step


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
    repetitions differ by more than that, and without any, the noise has it all. A joint that
    rests shows nothing of it.
    """
    steps = encoder_steps(recordings)
    share, compared = np.zeros(len(steps)), np.zeros(len(steps))
    for recording in recordings:
        period = recording.period
        if period is None or recording.repetitions < 2:
            continue
        interval = float(np.median(np.diff(recording.t)))
        turn = round(period / interval)
        moves = _moves(recording.q, steps, max(round(MOVING / interval), 2))[turn:]
        differs = moves & (np.abs(recording.q[turn:] - recording.q[:-turn]) > steps / 2)
        count = moves.sum(axis=0)
        share += count * np.clip(1 - 6 * differs.sum(axis=0) / np.maximum(count, 1), 0.0, 1.0)
        compared += count
    return steps * np.sqrt(share / np.maximum(compared, 1))


def _moves(
    q: Float[ndarray, "samples joints"], steps: Float[ndarray, " joints"], window: int
) -> Bool[ndarray, "samples joints"]:
    """Samples about which a joint moves by a step."""
    reach = maximum_filter1d(q, window, axis=0) - minimum_filter1d(q, window, axis=0)
    return reach > steps / 2


def rounding_deviation(steps: Float[ndarray, " joints"]) -> Float[ndarray, " joints"]:
    """(n,) standard deviation of what rounding to steps errs."""
    return steps / np.sqrt(12)


def _rounding(prepared: Prepared, rng: np.random.Generator) -> Float[ndarray, "logged joints"]:
    """What rounding to steps, counted from anywhere, errs: nothing new where a joint rests.

    In each repetition they are counted from elsewhere: one place alone is one of many.
    """
    steps = prepared.repeated_steps
    t, q = (prepared.band.as_logged(x) for x in (prepared.motion.t, prepared.motion.q))
    turn = np.zeros(len(t), dtype=int)
    if prepared.period is not None:
        turn = ((t - t[0]) // prepared.period).astype(int)
    start = rng.uniform(size=(turn[-1] + 1, len(steps)))[turn]
    safe = np.where(steps > 0, steps, 1.0)
    counted = q / safe + start
    return np.where(steps > 0, safe * (np.round(counted) - counted), 0.0)


def fine_encoder_torque(
    torque: Torque,
    prepared: Sequence[Prepared],
    deviations: Sequence[Float[ndarray, " joints"]] | None = None,
) -> list[Float[ndarray, "samples joints"]]:
    """Errors of the predicted torque as errors of the encoders make them [N m].

    Where the steps of an encoder lie is drawn: from positions that were smoothed it is not to be
    told any more. Errors of a given deviation are drawn for every sample of the log.

    Args:
        torque: Of a model with its parameters.
        prepared: Recordings.
        deviations: (n,) of each one's encoders [rad]; of the rounding that comes again in every
            repetition if None.
    """
    rng = np.random.default_rng(SEED)
    errors = []
    for k, p in enumerate(prepared):
        if deviations is None:
            rounded = _rounding(p, rng)
        else:
            shape = p.band.as_logged(p.motion.q).shape
            rounded = deviations[k] * rng.uniform(-np.sqrt(3), np.sqrt(3), shape)
        if not rounded.any():
            errors.append(np.zeros_like(p.fine_torque))
            continue
        change, rate, acceleration = p.band.differentiate(rounded)
        there = dataclasses.replace(
            p.motion,
            q=p.motion.q + change,
            dq=p.motion.dq + rate,
            ddq=p.motion.ddq + acceleration,
        )
        errors.append(torque(there) - torque(p.motion))
    return errors
