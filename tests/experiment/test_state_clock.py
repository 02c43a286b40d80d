"""A log's time is its controller's where q and dq tell that the stamps err, and the log's elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import convolve1d

from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording import Recording
from oed.experiment.signals.differentiation import spline_derivative
from oed.experiment.signals.resampling import resample, uniform_grid
from oed.experiment.state_clock import in_state_time
from tests.paths import SHARED_DATA, needs_shared_data

TICK = 1e-3  # [s]
FREQUENCY = np.array([0.3, 0.45, 0.7])  # [Hz] of the joints
AMPLITUDE = np.array([0.8, 0.5, 0.3])  # [rad]


def position(t: np.ndarray) -> np.ndarray:
    return AMPLITUDE * np.sin(2 * np.pi * FREQUENCY * t[:, None])


def velocity(t: np.ndarray) -> np.ndarray:
    return 2 * np.pi * FREQUENCY * AMPLITUDE * np.cos(2 * np.pi * FREQUENCY * t[:, None])


def recorded(state: np.ndarray, stamp: np.ndarray, *, error: float = 1e-6) -> Recording:
    """A log of states of these instants under these stamps; `error` of q [rad], of dq per 10 ms."""
    rng = np.random.default_rng(5)
    q = position(state) + error * rng.standard_normal((len(state), 3))
    dq = velocity(state) + 100 * error * rng.standard_normal((len(state), 3))
    return Recording(name="log", role="estimation", t=stamp, q=q, tau=q.copy(), dq=dq)


def stamped_late(seed: int, ticks: int = 5_000) -> tuple[np.ndarray, np.ndarray]:
    """Instants of states, some missed and some read twice, and stamps up to 3 ms late."""
    rng = np.random.default_rng(seed)
    times = rng.choice([0, 1, 2], p=[0.05, 0.9, 0.05], size=ticks)
    state = np.repeat(np.arange(ticks) * TICK, times)
    late = np.minimum(rng.exponential(0.3e-3, len(state)), 3e-3)
    stamp = np.maximum.accumulate(state + late)
    return state, stamp + 1e-9 * np.arange(len(stamp))  # time increases


def test_ticks_are_read_off_position_and_velocity():
    state, stamp = stamped_late(1, 10_000)
    log = recorded(state, stamp)

    found = in_state_time(log)

    fresh = np.append(True, np.diff(state) > 0)
    assert len(found) == fresh.sum()
    # Stamps are late by 0.3 ms in the mean, which no log can tell from a clock that is.
    apart = found.t - state[fresh]
    assert apart.std() < 0.1 * (log.t - state).std()
    assert len(found.notes) == 1
    assert "whole ticks of 1 ms" in found.notes[0]


def test_accelerations_that_no_arm_had_are_gone():
    state, stamp = stamped_late(2, 10_000)
    log = recorded(state, stamp)

    def error(recording: Recording) -> float:
        grid = uniform_grid(recording.t, 1 / TICK)
        q = resample(recording.t, recording.q, grid, "linear")
        true = -((2 * np.pi * FREQUENCY) ** 2) * position(grid)
        # Over 20 ms, as any filter of a log would.
        smooth = convolve1d(q, np.hanning(41) / np.hanning(41).sum(), axis=0)
        apart = (spline_derivative(smooth, 1 / TICK, 2) - true)[500:-500]
        return float(np.std(apart))

    assert error(in_state_time(log)) < 0.2 * error(log)


def test_rows_of_one_tick_leave_every_column():
    state, stamp = stamped_late(3)
    found = in_state_time(recorded(state, stamp))
    for column in (found.q, found.tau, found.dq):
        assert column is not None
        assert len(column) == len(found.t)
    assert (np.diff(found.t) > 0).all()


def test_stamps_that_are_right_stay():
    t = np.arange(5_000) * TICK
    log = recorded(t, t)
    assert in_state_time(log) is log


def test_uneven_stamps_that_are_right_stay():
    t = np.cumsum(np.random.default_rng(4).uniform(2e-3, 4e-3, 3_000))
    log = recorded(t, t)
    assert in_state_time(log) is log


def test_late_stamps_stay_where_velocity_is_too_coarse_to_tell():
    state, stamp = stamped_late(5)
    log = recorded(state, stamp, error=3e-3)
    assert in_state_time(log) is log


def test_a_pause_of_the_log_is_kept():
    state, stamp = stamped_late(6)
    pause = np.where(state > 2.0, 1.5, 0.0)
    found = in_state_time(recorded(state + pause, stamp + pause))
    longest = int(np.argmax(np.diff(found.t)))
    assert np.diff(found.t)[longest] == pytest.approx(1.5, abs=0.01)
    assert (np.diff(found.t) > 0.1).sum() == 1


@pytest.mark.parametrize("missing", ["dq", "joint"])
def test_what_cannot_tell_is_left_as_it_is(missing: str):
    state, stamp = stamped_late(7)
    log = recorded(state, stamp)
    if missing == "dq":
        log = Recording(name="log", role="test", t=log.t, q=log.q, tau=log.tau)
    else:
        one = slice(0, 1)
        assert log.dq is not None
        log = Recording(
            name="log",
            role="test",
            t=log.t,
            q=log.q[:, one],
            tau=log.tau[:, one],
            dq=log.dq[:, one],
        )
    assert in_state_time(log) is log


@needs_shared_data
def test_of_the_measured_arms_only_the_one_with_late_stamps_is_moved():
    """Its source's own quirks: steps of 0.7 to 8.8 ms around 1 ms, one row in 20 repeats."""
    moved = {
        name: read_dataset(SHARED_DATA / name).notes
        for name in ("franka_panda", "dfki_a0", "staubli_tx40")
    }
    assert not moved["dfki_a0"]
    assert not moved["staubli_tx40"]
    assert len(moved["franka_panda"]) == 4
    assert all("whole ticks of" in note for note in moved["franka_panda"])
