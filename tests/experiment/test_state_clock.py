"""A log's time is its controller's where positions tell that the stamps err, and the log's elsewhere."""

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


def recorded(state: np.ndarray, stamp: np.ndarray, *, error: float = 1e-6) -> Recording:
    """A log of states of these instants under these stamps; `error` is its encoders' [rad]."""
    q = position(state) + error * np.random.default_rng(5).standard_normal((len(state), 3))
    q = q[np.searchsorted(state, state)]  # a state that is read twice is the same
    return Recording(
        "log", "estimation", t=stamp, q=q, tau=2 * q, dq=3 * q, temperature=20 + q[:, :1]
    )


def stamped_late(seed: int, ticks: int = 5_000) -> tuple[np.ndarray, np.ndarray]:
    """Instants of states, some missed and some read twice, and stamps up to 3 ms late."""
    rng = np.random.default_rng(seed)
    times = rng.choice([0, 1, 2], p=[0.05, 0.9, 0.05], size=ticks)
    state = np.repeat(np.arange(ticks) * TICK, times)
    late = np.minimum(rng.exponential(0.3e-3, len(state)), 3e-3)
    stamp = np.maximum.accumulate(state + late)
    return state, stamp + 1e-9 * np.arange(len(stamp))  # time increases


def test_ticks_are_read_off_positions():
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
        q = resample(recording.t, recording.q, grid)
        true = -((2 * np.pi * FREQUENCY) ** 2) * position(grid)
        # Over 20 ms, as any filter of a log would.
        smooth = convolve1d(q, np.hanning(41) / np.hanning(41).sum(), axis=0)
        apart = (spline_derivative(smooth, 1 / TICK, 2) - true)[500:-500]
        return float(np.std(apart))

    assert error(in_state_time(log)) < 0.2 * error(log)


def test_rows_of_one_tick_leave_every_column():
    state, stamp = stamped_late(3)
    log = recorded(state, stamp)
    found = in_state_time(log)
    fresh = np.append(True, np.diff(state) > 0)
    for name in ("q", "tau", "dq", "temperature"):
        assert np.array_equal(getattr(found, name), getattr(log, name)[fresh])
    assert (np.diff(found.t) > 0).all()


def test_stamps_that_are_right_stay():
    t = np.arange(5_000) * TICK
    log = recorded(t, t)
    assert in_state_time(log) is log


def test_uneven_stamps_that_are_right_stay():
    t = np.cumsum(np.random.default_rng(4).uniform(2e-3, 4e-3, 3_000))
    log = recorded(t, t)
    assert in_state_time(log) is log


def test_late_stamps_stay_where_positions_are_too_coarse_to_tell():
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


def test_one_joint_alone_tells_nothing():
    state, stamp = stamped_late(7)
    log = recorded(state, stamp)
    alone = Recording(name="log", role="test", t=log.t, q=log.q[:, :1], tau=log.tau[:, :1])
    assert in_state_time(alone) is alone


def test_rows_that_repeat_under_right_stamps_are_no_late_ones():
    ticks = np.arange(5_000)
    stale = np.random.default_rng(8).random(len(ticks)) < 0.05
    read = np.maximum.accumulate(np.where(stale, 0, ticks))
    log = recorded(read * TICK, ticks * TICK)
    assert in_state_time(log) is log


@pytest.mark.parametrize("rows", [2, 10])
def test_a_position_that_is_held_while_torque_goes_on_is_no_late_stamp(rows: int):
    t = np.arange(10_000) * TICK
    log = recorded(np.repeat(t[::rows], rows), t)
    noisy = log.tau + np.random.default_rng(9).standard_normal(log.tau.shape)
    held = Recording("log", "estimation", t=t, q=log.q, tau=noisy)
    assert in_state_time(held) is held


def test_seconds_since_1970_are_told_as_well():
    state, stamp = stamped_late(10)
    stamp += 1e-6 * np.arange(len(stamp))  # no two are the same to the last bit
    found, early = (in_state_time(recorded(state, stamp + start)) for start in (1.7e9, 0.0))
    assert len(found.notes) == 1
    # Such a number of seconds has 0.24 microseconds to its last bit.
    assert found.t - 1.7e9 == pytest.approx(early.t, abs=2e-6)


@needs_shared_data
def test_of_the_measured_arms_only_the_one_with_late_stamps_is_moved():
    """Its source's own quirks: steps of 0.7 to 8.8 ms around 1 ms, one row in 20 repeats."""
    moved = {
        name: [n for n in read_dataset(SHARED_DATA / name).notes if "time stamps" in n]
        for name in ("franka_panda", "dfki_a0", "staubli_tx40")
    }
    assert not moved["dfki_a0"]
    assert not moved["staubli_tx40"]
    assert len(moved["franka_panda"]) == 4
    assert all("whole ticks of" in note for note in moved["franka_panda"])
