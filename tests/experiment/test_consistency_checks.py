"""Columns that contradict one another are refused with the likely cause; real logs pass."""

from collections.abc import Callable

import numpy as np
import pytest

from oed.errors import DataSetError
from oed.experiment.consistency_checks import check_repeats, check_speed, check_velocity
from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording_checks import check_time
from oed.robot import imi_scara
from tests.paths import SHARED_DATA, needs_shared_data

ROBOT = imi_scara()  # velocity limits of a few rad/s
Logged = tuple[np.ndarray, np.ndarray, np.ndarray]


def multisine(rate: float = 200.0, duration: float = 20.0) -> Logged:
    """Time, positions and velocities of two joints, period 5 s."""
    t = np.arange(0.0, duration, 1 / rate)
    w = 2 * np.pi * np.array([[0.4, 0.6], [1.0, 1.4]])
    phase = t[:, None, None] * w
    return t, np.sin(phase).sum(axis=2) / 3, (w * np.cos(phase)).sum(axis=2) / 3


def as_a_drive_logs(t: np.ndarray, q: np.ndarray, dq: np.ndarray) -> Logged:
    """Encoder steps, noise, an offset, a delay of 10 ms and one spike of the velocity."""
    rng = np.random.default_rng(0)
    late = np.stack([np.interp(t - 0.01, t, column) for column in dq.T], axis=1)
    late += 0.02 + 0.2 * rng.normal(size=dq.shape)
    late[100] = 1e3
    return t, np.round(q, 3), late


@pytest.mark.parametrize("rate", [20.0, 200.0, 2000.0])
def test_a_velocity_that_is_the_slope_passes(rate: float) -> None:
    check_velocity(*multisine(rate), ROBOT, "log.csv")
    check_velocity(*as_a_drive_logs(*multisine(rate)), ROBOT, "log.csv")


@pytest.mark.parametrize(
    ("spoil", "column", "why"),
    [
        (lambda t, q, dq: (t, q, np.rad2deg(dq)), "dq_1", "57.*degrees per second"),
        (lambda t, q, dq: (t, q, dq * [1, 180 / np.pi]), "dq_2", "5[678].*degrees per second"),
        (lambda t, q, dq: (t, np.rad2deg(q), dq), "dq_1", r"0\.017.*q looks like degrees"),
        (lambda t, q, dq: (1e3 * t, q, dq), "dq_1", "100[01].*milliseconds"),
        (lambda t, q, dq: (t, q, dq / 1e3), "dq_1", r"0\.001.*per millisecond"),
        (lambda t, q, dq: (t, q, dq[:, ::-1]), "dq_1", "dq_2 fits this joint"),
        (lambda t, q, dq: (t, q, dq * [1, -1]), "dq_2", "sign is reversed"),
        (lambda t, q, dq: (t, q, dq * [101, -101]), "dq_1", "motor before the gear"),
        (lambda t, q, dq: (t, q, dq * [1, 0]), "dq_2", "not logged"),
        (lambda t, q, dq: (t, q, q), "dq_1", "of another joint"),
    ],
)
def test_a_velocity_of_another_unit_or_joint_is_refused(
    spoil: Callable[..., Logged], column: str, why: str
) -> None:
    with pytest.raises(DataSetError, match=why) as caught:
        check_velocity(*spoil(*as_a_drive_logs(*multisine())), ROBOT, "log.csv")
    assert caught.value.column == column
    assert f"joint_{column[-1]}" in str(caught.value)


def test_a_joint_that_is_held_may_log_any_velocity() -> None:
    t, q, dq = multisine()
    q[:, 1] = 0.3 + 0.01 * np.sin(t)
    dq[:, 1] = 0.0
    check_velocity(t, q, dq, ROBOT, "log.csv")


def test_what_happened_within_a_gap_is_not_held_against_a_velocity() -> None:
    """The arm came back from elsewhere while nothing was logged, again and again."""
    t, q, dq = multisine(duration=200.0)
    kept = np.mod(t, 4.0) < 1.5
    check_velocity(t[kept], q[kept] + np.floor(t[kept] / 4.0)[:, None], dq[kept], ROBOT, "log.csv")


@pytest.mark.parametrize(
    ("rate", "factor", "unit"),
    [
        (100.0, 1e3, "milliseconds"),
        (1000.0, 1e3, "milliseconds"),
        (5000.0, 1e3, "milliseconds"),
        (1000.0, 1e6, "microseconds"),
        (1000.0, 1e9, "nanoseconds"),
    ],
)
def test_time_that_cannot_be_seconds_is_refused(rate: float, factor: float, unit: str) -> None:
    t = np.arange(200) / rate
    check_time(t + 1.7e9, "log.csv", np.arange(len(t)) + 2)
    with pytest.raises(DataSetError, match=unit) as caught:
        check_time(factor * t, "log.csv", np.arange(len(t)) + 2)
    assert caught.value.column == "t"


def test_speeds_far_beyond_the_limits_are_refused_and_a_few_spikes_are_not() -> None:
    t, q, _ = multisine()
    check_speed(t, q, ROBOT, "log.csv")
    spiked = q.copy()
    spiked[::100] += 3.0
    check_speed(t, spiked, ROBOT, "log.csv")
    with pytest.raises(DataSetError, match="times its velocity limit") as caught:
        check_speed(t, np.rad2deg(q) * [0, 1], ROBOT, "log.csv")
    assert caught.value.column == "q_2"


def test_repetitions_as_a_poor_controller_runs_them_pass() -> None:
    t, q, _ = multisine()
    rng = np.random.default_rng(1)
    repetition = np.floor(t / 5 + 1e-9).astype(int)
    tracked = q + 0.05 * rng.normal(size=(4, 2))[repetition] + 0.01 * rng.normal(size=q.shape)
    check_repeats(t, tracked, repetition, 5.0, "log.csv")
    check_repeats(t, tracked, repetition, None, "log.csv")


def test_a_last_repetition_that_was_broken_off_is_not_held_against_the_others() -> None:
    t, q, _ = multisine(duration=15.5)
    check_repeats(t, q, np.floor(t / 5 + 1e-9).astype(int), None, "log.csv")


@pytest.mark.parametrize("repetitions", [2, 3, 7])
def test_a_period_that_is_none_is_refused(repetitions: int) -> None:
    t, q, _ = multisine()
    period = 20.0 / repetitions
    if repetitions == 2:  # four periods of the motion would be two of this
        q = q + 0.5 * np.sin(0.2 * t)[:, None]
    repetition = np.minimum(np.floor(t / period).astype(int), repetitions - 1)
    for at in (period, None):
        with pytest.raises(DataSetError, match="does not repeat") as caught:
            check_repeats(t, q, repetition, at, "log.csv")
        assert caught.value.column == "q_1"


def test_one_repetition_that_is_another_motion_is_named() -> None:
    t, q, _ = multisine()
    q[(t >= 10) & (t < 15)] *= -1
    with pytest.raises(DataSetError, match="repetition 2 departs from the mean of 4"):
        check_repeats(t, q, np.floor(t / 5 + 1e-9).astype(int), 5.0, "log.csv")


@needs_shared_data
@pytest.mark.parametrize("name", ["dfki_a0", "franka_panda"])
def test_measured_velocities_pass_by_far_and_in_degrees_they_do_not(name: str) -> None:
    dataset = read_dataset(SHARED_DATA / name)
    for recording in dataset.recordings:
        t, q, dq = recording.t, recording.q, recording.dq
        assert dq is not None
        for factor in (0.6, 1.7):
            check_velocity(t, q, factor * dq, dataset.robot, recording.source)
        with pytest.raises(DataSetError, match="degrees per second"):
            check_velocity(t, q, np.rad2deg(dq), dataset.robot, recording.source)
