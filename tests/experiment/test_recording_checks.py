"""Numbers that are read without fault and cannot be a recording: time, repetitions, units, rest."""

import numpy as np
import pandas as pd
import pytest

from oed.errors import DataSetError
from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording_checks import check_turns
from oed.robot.builtin import imi_scara
from tests.experiment.tiny_dataset import (
    csv_text,
    refused,
    spoil,
    tiny_files,
    with_line,
    write_files,
)


def test_time_that_repeats(tmp_path):
    error = refused(with_line(tmp_path, 7, "0.4,0.1,0.2,0.3,0.4"))
    assert (error.row, error.column) == (7, "t")
    assert "repeats" in str(error)


def test_time_that_runs_back(tmp_path):
    error = refused(with_line(tmp_path, 7, "0.3,0.1,0.2,0.3,0.4"))
    assert (error.row, error.column) == (7, "t")
    assert "runs back" in str(error)


def test_time_since_1970_that_runs_back_shows_how(tmp_path):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "test.csv")
    frame["t"] += 1.66e9
    frame.loc[7, "t"] -= 0.15
    frame.to_csv(tmp_path / "test.csv", index=False)
    error = refused(tmp_path)
    assert error.row == 9
    assert "1660000000.6 s is followed by 1660000000.55 s" in str(error)


def test_time_in_milliseconds(tmp_path):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "test.csv")
    frame["t"] *= 1000
    frame.to_csv(tmp_path / "test.csv", index=False)
    error = refused(tmp_path)
    assert error.column == "t"
    assert "milliseconds" in str(error)


def test_fewer_rows_than_parameters(tmp_path):
    files = tiny_files() | {"estimation.csv": csv_text(0, rows=23).encode()}
    assert "23 rows are fewer than the 24 parameters" in str(refused(write_files(tmp_path, files)))


@pytest.mark.parametrize(("old", "new"), [("period = 1.0", "period = 1.1"), ("= 3", "= 2")])
def test_repetitions_that_the_time_column_contradicts(tmp_path, old, new):
    error = refused(spoil(tmp_path, "dataset.toml", old, new))
    assert error.file.endswith("estimation.csv")
    assert error.column == "t"


def test_repetitions_that_the_repetition_column_contradicts(tmp_path):
    files = tiny_files()
    lines = csv_text(0).splitlines()
    lines = [lines[0] + ",repetition", *(f"{x},{i // 15}" for i, x in enumerate(lines[1:]))]
    files["estimation.csv"] = ("\n".join(lines) + "\n").encode()
    assert refused(write_files(tmp_path, files)).column == "repetition"


@pytest.mark.parametrize("cell", ["0.5", "-1"])
def test_repetition_that_is_no_index(tmp_path, cell):
    files = tiny_files()
    lines = csv_text(0).splitlines()
    lines = [lines[0] + ",repetition", *(f"{x},0" for x in lines[1:])]
    lines[4] = lines[4][:-1] + cell
    files["estimation.csv"] = ("\n".join(lines) + "\n").encode()
    error = refused(write_files(tmp_path, files))
    assert (error.row, error.column) == (5, "repetition")


def test_a_period_at_which_the_motion_does_not_repeat(tmp_path):
    files = tiny_files()
    text = files["dataset.toml"].decode().replace("repetitions = 3", "repetitions = 6")
    files["dataset.toml"] = text.replace("period = 1.0", "period = 0.5").encode()
    error = refused(write_files(tmp_path, files))
    assert error.column == "q_1"
    assert "does not repeat" in str(error)


def test_positions_in_degrees(tmp_path):
    folder = write_files(tmp_path, tiny_files())
    frame = pd.read_csv(folder / "test.csv")
    frame[["q_1", "q_2"]] *= 180 / np.pi
    frame.to_csv(folder / "test.csv", index=False)
    error = refused(folder)
    assert "degrees" in str(error)
    assert error.column == "q_1"
    assert error.row == frame["q_1"].abs().argmax() + 2


@pytest.mark.parametrize("rows", [slice(300, None), slice(300, 301)])
def test_an_encoder_that_leaps(rows):
    robot = imi_scara()
    t = np.arange(2000) / 500.0
    q = np.stack([0.4 * np.sin(2.0 * t), 0.3 * np.cos(1.3 * t)], axis=1)
    check_turns(t, q, robot, "test.csv", np.arange(len(t)) + 2)
    q[rows, 1] += 0.2
    with pytest.raises(DataSetError, match="leaps") as caught:
        check_turns(t, q, robot, "test.csv", np.arange(len(t)) + 2)
    assert (caught.value.row, caught.value.column) == (302, "q_2")


def test_a_joint_that_starts_and_stops_does_not_leap():
    robot = imi_scara()
    t = np.arange(2000) / 100.0
    moves = np.clip(20 * (t % 5.0 - 2.0), 0.0, 1.0)  # 0.05 s a move, five rows of it
    q = np.stack([moves, 0.3 * np.cos(1.3 * t)], axis=1)
    check_turns(t, q, robot, "test.csv", np.arange(len(t)) + 2)


def test_an_angle_that_is_folded_into_one_turn(tmp_path):
    folder = write_files(tmp_path, tiny_files())
    frame = pd.read_csv(folder / "test.csv")
    turning = np.pi - 0.5 + frame["t"]  # within the joint's range, once through pi
    frame["q_2"] = np.mod(turning + np.pi, 2 * np.pi) - np.pi
    frame.to_csv(folder / "test.csv", index=False)
    error = refused(folder)
    assert error.column == "q_2"
    assert error.row == int(np.argmax(turning >= np.pi)) + 2
    frame["q_2"] = turning
    frame.to_csv(folder / "test.csv", index=False)
    assert np.array_equal(read_dataset(folder).test[0].q[:, 1], turning)


def test_speeds_beyond_all_limits(tmp_path):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "test.csv")
    frame["t"] /= 20
    frame.to_csv(tmp_path / "test.csv", index=False)
    assert "times its velocity limit" in str(refused(tmp_path))


def test_a_velocity_of_another_joint(tmp_path):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "test.csv")
    for j in (1, 2):
        frame[f"q_{j}"] = np.sin(j * frame["t"])
        frame[f"dq_{j}"] = j * np.cos(j * frame["t"])
    frame.to_csv(tmp_path / "test.csv", index=False)
    assert read_dataset(tmp_path).test[0].dq is not None
    swapped = frame.rename(columns={"dq_1": "dq_2", "dq_2": "dq_1"})
    swapped.to_csv(tmp_path / "test.csv", index=False)
    assert "the columns are exchanged" in str(refused(tmp_path))


def test_torque_that_was_not_logged(tmp_path):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "estimation.csv")
    frame["tau_2"] = 0.0
    frame.to_csv(tmp_path / "estimation.csv", index=False)
    error = refused(tmp_path)
    assert "the torque of joint 'joint_2' is 0 in every row: it was not logged" in str(error)


@pytest.mark.parametrize("cell", ["1e300", "-1e21"])
def test_rows_that_no_recording_reads_are_not_judged(tmp_path, cell):
    lines = (write_files(tmp_path, tiny_files()) / "test.csv").read_text().splitlines()
    for i in (1, 2, 3):
        lines[i] = f"{lines[i].rpartition(',')[0]},{cell}"
    (tmp_path / "test.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    error = refused(tmp_path)
    assert (error.row, error.column) == (2, "tau_2")
    manifest = (tmp_path / "dataset.toml").read_text()
    cut = manifest.replace('file = "test.csv"', f'file = "test.csv"\nrows = [4, {len(lines) - 1}]')
    (tmp_path / "dataset.toml").write_text(cut)
    assert len(read_dataset(tmp_path).test[0].t) == len(lines) - 4


def test_an_arm_at_rest(tmp_path):
    frame = pd.read_csv(write_files(tmp_path, tiny_files()) / "estimation.csv")
    frame[["q_1", "q_2"]] = 1e-5 * np.random.default_rng(0).normal(size=(len(frame), 2))
    frame.to_csv(tmp_path / "estimation.csv", index=False)
    assert "an arm at rest" in str(refused(tmp_path))
