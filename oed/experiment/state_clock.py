"""Time as the controller's own ticks tell it, where the log's stamps do not.

A computer that reads a controller stamps each row when it gets to it, while the positions are of
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

from oed.counted import counted
from oed.experiment.preparation.fresh import fresh_samples
from oed.experiment.recording import Recording
from oed.experiment.signals.gaps import find_gaps

CLEAR = 1 / 6  # of a tick, to which a step must be known to be counted
MOST = 0.5  # share of the steps that must be clear
WHOLE = 0.1  # of a tick, rms, by which they may miss whole ticks; any steps miss by 0.29
# Share of the steps without a tick: more is a position that is held while torque goes on.
AGAIN = 0.1
# Ratio of the errors of q with ticks and with stamps. Where stamps are right, both are what encoders
# err by (0.95 to 1.2 in two measured logs); where they were late, ticks left 0.03.
FAR_BETTER = 0.5
SMOOTH = 0.05  # [s] over which velocity is the slope of q: no arm's changes much
AGREE = 3.0  # [s] over which the mean of both clocks is the same


def in_state_time(recording: Recording) -> Recording:
    """A recording in its controller's time, if its positions show that the stamps err.

    Rows that read a tick again are left out, and a note says so. Where nothing shows, or there is
    one joint alone, the recording is returned as it is.

    Args:
        recording: As it was logged.
    """
    fresh = fresh_samples(recording)
    stamps = recording.t[fresh]
    steps = _steps(stamps, recording.q[fresh])
    if steps is None:
        return recording
    own = stamps[0] + np.append(0.0, np.cumsum(steps))
    tick = float(np.median(steps))
    # Both clocks go at one rate, whatever an oscillator drifts by.
    window = min(len(own), round(AGREE / tick))
    t = own + uniform_filter1d(stamps - own, window, mode="nearest")
    fresh[fresh] = new = np.append(True, steps > 0)
    error = (stamps - t)[new]
    note = (
        f"{recording.name}: time stamps err by {1e3 * error.std():.2g} ms rms, "
        f"{1e3 * np.abs(error).max():.2g} ms at most, against whole ticks of {1e3 * tick:.4g} ms "
        "that the positions tell; time is taken from these, without "
        f"{counted(int((~fresh).sum()), 'row that reads', 'rows that read')} a tick again"
    )
    # Whatever has a row for each sample.
    rows = {
        field.name: value[fresh]
        for field in dataclasses.fields(recording)
        if isinstance(value := getattr(recording, field.name), ndarray)
    }
    return dataclasses.replace(recording, **rows | {"t": t[new]}, notes=(*recording.notes, note))


def _steps(
    stamps: Float[ndarray, " samples"], q: Float[ndarray, "samples joints"]
) -> Float[ndarray, " steps"] | None:
    """Time from each row to the next as ticks tell it [s]; None where stamps are no worse.

    Least squares over the joints gives what has passed, and what they leave its error. Where the
    arm is too slow to tell, stamps are kept.
    """
    joints = q.shape[1]
    if joints < 2 or len(stamps) < 3:
        return None
    logged, moved = np.diff(stamps), np.diff(q, axis=0)
    tick = float(np.median(logged))
    span = 2 * round(SMOOTH / tick / 2) + 1
    # Over so many rows late stamps hardly matter, which over one are most of the error.
    speed = uniform_filter1d(moved, span, axis=0) / uniform_filter1d(logged, span)[:, None]
    squares = np.maximum(np.sum(speed**2, axis=1), np.finfo(float).tiny)
    passed = np.sum(moved * speed, axis=1) / squares
    missed = moved - speed * passed[:, None]
    deviation = np.sqrt(np.sum(missed**2) / (len(missed) * (joints - 1)))
    count = np.round(passed / tick)
    clear = (deviation < CLEAR * tick * np.sqrt(squares)) & (count >= 0)
    gaps = np.zeros(len(logged))
    gaps[find_gaps(stamps, np.inf)] = 1.0
    clear &= uniform_filter1d(gaps, span) == 0.0
    if clear.mean() < MOST or np.std((passed / tick - count)[clear]) > WHOLE:
        return None
    if np.mean(count[clear] == 0) > AGAIN:
        return None
    # Of stamps that are rounded or late, the median is a tick but for some per cent.
    tick = float(logged[clear].sum() / count[clear].sum())
    by_ticks, by_stamps = (
        np.sum((moved - speed * steps[:, None])[clear] ** 2) for steps in (tick * count, logged)
    )
    if by_ticks > FAR_BETTER**2 * by_stamps:
        return None
    return np.where(clear, tick * count, logged)
