"""Data sets from arrays and frames in memory, checked as files are."""

import numpy as np
import pandas as pd
import pytest

from oed.errors import DataSetError
from oed.experiment.dataset import DataSet
from oed.experiment.log_format import LogFormat
from oed.robot.builtin import imi_scara


@pytest.fixture
def motion():
    t = np.arange(0, 20, 0.01)
    q = np.column_stack([np.sin(0.7 * t) + 0.3 * np.sin(1.9 * t), np.cos(0.011 * t**2)])
    tau = np.random.default_rng(0).normal(size=q.shape)
    return t, q, tau


def test_one_recording_is_divided_and_a_note_says_how(motion):
    t, q, tau = motion
    dataset = DataSet.from_arrays(imi_scara(), t=t, q=q, tau=tau)
    assert [r.role for r in dataset.recordings] == ["estimation", "validation", "test"]
    assert np.array_equal(np.concatenate([r.q for r in dataset.recordings]), q)
    assert np.array_equal(np.concatenate([r.tau for r in dataset.recordings]), tau)
    assert "60, 20 and 20 %" in dataset.notes[0]


def test_several_recordings_with_roles(motion):
    t, q, tau = motion
    dataset = DataSet.from_arrays(
        imi_scara(), t=[t, t], q=[q, q[::-1]], tau=[tau, -tau], roles=["test", "estimation"]
    )
    assert np.array_equal(dataset.estimation[0].tau, -tau)
    assert np.array_equal(dataset.test[0].q, q)


def test_units_are_checked_as_in_files(motion):
    t, q, tau = motion
    with pytest.raises(DataSetError, match="degrees"):
        DataSet.from_arrays(imi_scara(), t=t, q=np.rad2deg(q), tau=tau)


def test_shapes_that_disagree(motion):
    t, q, tau = motion
    with pytest.raises(ValueError, match="must be"):
        DataSet.from_arrays(imi_scara(), t=t, q=q[:, :1], tau=tau)
    with pytest.raises(ValueError, match="numbers of recordings disagree"):
        DataSet.from_arrays(imi_scara(), t=[t, t], q=[q], tau=[tau])
    with pytest.raises(ValueError, match="1 role for 2"):
        DataSet.from_arrays(imi_scara(), t=[t, t], q=[q, q], tau=[tau, tau], roles=["test"])


def test_a_frame_by_joints_names_with_time_as_its_index(motion):
    t, q, tau = motion
    columns = {
        f"{key}_joint_{j + 1}": a[:, j] for key, a in (("q", q), ("tau", tau)) for j in (1, 0)
    }
    frame = pd.DataFrame(columns, index=pd.Index(t, name="time"))
    dataset = DataSet.from_frame(imi_scara(), frame)
    assert np.array_equal(np.concatenate([r.q for r in dataset.recordings]), q)


def test_a_frame_in_degrees_without_time(motion):
    t, q, tau = motion
    frame = pd.DataFrame(
        {"a": np.rad2deg(q[:, 0]), "b": np.rad2deg(q[:, 1]), "c": tau[:, 0], "d": tau[:, 1]}
    )
    log_format = LogFormat(
        columns={"q": ("a", "b"), "tau": ("c", "d")}, units={"q": ("deg",)}, rate=100.0
    )
    dataset = DataSet.from_frame(
        imi_scara(), [frame, frame], log_format=log_format, roles=["estimation", "test"]
    )
    assert np.allclose(dataset.test[0].q, q, rtol=0, atol=1e-14)
    assert np.allclose(dataset.test[0].t, t, rtol=0, atol=1e-12)
    with pytest.raises(ValueError, match="no column of time"):
        DataSet.from_frame(
            imi_scara(), frame.rename(columns={"a": "q_1", "b": "q_2", "c": "tau_1", "d": "tau_2"})
        )


@pytest.mark.parametrize("times", ["index", "column", "duration"])
def test_a_frame_with_times_of_pandas(motion, times):
    t, q, tau = motion
    since = pd.to_timedelta(t, unit="s")
    clock = since if times == "duration" else pd.Timestamp("2026-01-31T23:59:55Z") + since
    columns = {f"{key}_{j + 1}": a[:, j] for key, a in (("q", q), ("tau", tau)) for j in (0, 1)}
    frame = pd.DataFrame(columns, index=clock if times == "index" else None)
    if times != "index":
        frame["time"] = clock
    dataset = DataSet.from_frame(imi_scara(), frame)
    read = np.concatenate([r.t for r in dataset.recordings])
    assert np.allclose(np.diff(read), np.diff(t), rtol=0, atol=1e-8)


def test_runs_in_one_array_are_recordings_of_their_own(motion):
    t, q, tau = motion
    twice = {
        "t": np.concatenate([t, t]),
        "q": np.vstack([q, q[::-1]]),
        "tau": np.vstack([tau, tau]),
    }
    dataset = DataSet.from_arrays(imi_scara(), **twice)
    assert [r.role for r in dataset.recordings] == ["estimation", "validation"]
    assert np.array_equal(dataset.validation[0].q, q[::-1])
    fitted = DataSet.from_arrays(imi_scara(), **twice, roles=["estimation"])
    assert [r.name for r in fitted.recordings] == ["1-estimation", "2-estimation"]
