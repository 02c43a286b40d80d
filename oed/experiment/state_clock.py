"""Time as the controller's own ticks tell it, where the log's stamps do not.

A computer that reads a controller stamps each row when it gets to it; position and velocity are of
one tick of the controller's clock. From row to row each joint moves by its velocity times what has
passed, so that several joints tell together how many ticks that were. A stamp that is a
millisecond late makes accelerations that no arm had, for which the torque seems to lag.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.ndimage import uniform_filter1d

from oed.experiment.recording import Recording
from oed.experiment.signals.gaps import find_gaps

CLEAR = 1 / 6  # of a tick, to which a step must be known to be counted
MOST = 0.5  # share of the steps that must be clear
WHOLE = 0.1  # of a tick, rms, by which they may miss whole ticks; any steps miss by 0.29
# Ratio of the errors of q with ticks and with stamps: stamps that are right leave 0.95 and more of
# what encoders and velocities err by (0.95 to 1.01 in a log of 200 Hz), late ones 0.04 to 0.08.
FAR_BETTER = 0.5
AGREE = 3.0  # [s] over which the mean of both clocks is the same


def in_state_time(recording: Recording) -> Recording:
    """A recording in its controller's time, if positions and velocities show that stamps err.

    Rows of a tick that was read before are left out, and a note says so. Where nothing shows, or
    no velocity was logged, the recording is returned as it is.

    Args:
        recording: As it was logged.
    """
    steps = _steps(recording)
    if steps is None:
        return recording
    own = np.append(0.0, np.cumsum(steps))
    late = recording.t - own
    window = min(len(late), round(AGREE / float(np.median(steps))))
    # Both clocks go at one rate, whatever an oscillator drifts by.
    t = own + uniform_filter1d(late, window, mode="nearest")
    fresh = np.append(True, steps > 0)
    error = (recording.t - t)[fresh]
    note = (
        f"{recording.name}: time stamps err by {1e3 * error.std():.2g} ms rms, "
        f"{1e3 * np.abs(error).max():.2g} ms at most, against whole ticks of "
        f"{1e3 * float(np.median(steps)):.4g} ms that q and dq tell; time is taken from these, and "
        f"{int((~fresh).sum())} rows that read a tick again are left out"
    )
    # Whatever has a row for each sample.
    rows = {
        field.name: value[fresh]
        for field in dataclasses.fields(recording)
        if isinstance(value := getattr(recording, field.name), ndarray)
    }
    return dataclasses.replace(recording, **rows | {"t": t[fresh]}, notes=(*recording.notes, note))


def _steps(recording: Recording) -> Float[ndarray, " steps"] | None:
    """Time from each row to the next as ticks tell it [s]; None where stamps are no worse.

    Least squares over the joints gives what has passed, and what they leave its error. Where the
    arm is too slow to tell, stamps are kept.
    """
    if recording.dq is None or recording.n < 2 or len(recording) < 3:
        return None
    logged, moved = np.diff(recording.t), np.diff(recording.q, axis=0)
    speed = (recording.dq[1:] + recording.dq[:-1]) / 2
    squares = np.maximum(np.sum(speed**2, axis=1), np.finfo(float).tiny)
    passed = np.sum(moved * speed, axis=1) / squares
    missed = moved - speed * passed[:, None]
    deviation = np.sqrt(np.sum(missed**2) / (len(missed) * (recording.n - 1)))
    tick = float(np.median(logged))
    count = np.round(passed / tick)
    clear = (deviation < CLEAR * tick * np.sqrt(squares)) & (count >= 0)
    clear[find_gaps(recording.t, np.inf)] = False
    if clear.mean() < MOST or np.std((passed / tick - count)[clear]) > WHOLE:
        return None
    # Of stamps that are rounded or late, the median is a tick but for some per cent.
    whole = float(logged[clear].sum())
    tick = whole / float(count[clear].sum())
    by_ticks, by_stamps = (
        np.sum((moved - speed * steps[:, None])[clear] ** 2) for steps in (tick * count, logged)
    )
    if by_ticks > FAR_BETTER**2 * by_stamps:
        return None
    return np.where(clear, tick * count, logged)
