"""Reading a whole folder: the robot, the joints chosen of it, limits, drives, measured sets."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording import Recording
from tests.experiment.tiny_dataset import (
    MANIFEST,
    csv_text,
    refused,
    spoil,
    tiny_files,
    urdf_text,
    with_urdf,
    write_files,
)
from tests.paths import SHARED_DATA, needs_shared_data


def test_reads_what_is_there(tmp_path):
    dataset = read_dataset(write_files(tmp_path, tiny_files()))
    expected = np.loadtxt(tmp_path / "estimation.csv", delimiter=",", skiprows=1)
    (recording,) = dataset.estimation
    assert [r.name for r in dataset.test] == ["test"]
    assert dataset.validation == ()
    assert np.array_equal(recording.t, expected[:, 0])
    assert np.array_equal(recording.q, expected[:, 1:3])
    assert np.array_equal(recording.tau, expected[:, 3:])
    assert recording.dq is None
    assert recording.repetition is not None
    assert recording.repetition.tolist() == [k // 10 for k in range(30)]
    assert dataset.robot.joint_names == ("joint_1", "joint_2")


def test_unknown_columns_are_reported(tmp_path):
    files = tiny_files()
    lines = csv_text(0).splitlines()
    lines = [lines[0] + ",note,current_9", *(line + ",ok," for line in lines[1:])]
    files["estimation.csv"] = ("\n".join(lines) + "\n").encode()
    dataset = read_dataset(write_files(tmp_path, files))
    assert dataset.estimation[0].unused_columns == ("note", "current_9")
    assert [column for _, column in dataset.unused] == ["note", "current_9"]


def test_currents_become_torques(tmp_path):
    plain = read_dataset(write_files(tmp_path / "plain", tiny_files()))
    folder = spoil(
        tmp_path / "drive",
        "dataset.toml",
        '[[recording]]\nfile = "est',
        '[drive]\ncurrent_to_torque = [2.0, -3.0]\ngear_ratio = [5, 6]\n[[recording]]\nfile = "est',
    )
    dataset = read_dataset(folder)
    assert np.array_equal(dataset.test[0].tau, plain.test[0].tau * [2.0, -3.0])
    assert dataset.drive.gear_ratio is not None
    assert dataset.drive.gear_ratio.tolist() == [5.0, 6.0]


def test_limits_of_the_data_set_override_those_of_the_robot(tmp_path):
    folder = spoil(
        tmp_path,
        "dataset.toml",
        '[[recording]]\nfile = "est',
        '[limits]\nposition = [[-2, 1], [-1, 3]]\nvelocity = [7, 6]\n[[recording]]\nfile = "est',
    )
    limits = read_dataset(folder).robot.limits
    assert limits.position.tolist() == [[-2, 1], [-1, 3]]
    assert limits.velocity.tolist() == [[-7, 7], [-6, 6]]
    assert limits.acceleration.tolist() == [[-5, 5], [-5, 5]]  # the robot's own


def left_out(recording: Recording) -> int:
    """Rows that a note says were left out, for they read a tick of the controller again."""
    found = [re.search(r"(\d+) rows that read a tick again", note) for note in recording.notes]
    return sum(int(match[1]) for match in found if match)


@needs_shared_data
@pytest.mark.parametrize(
    ("name", "joints", "rows"),
    [
        ("dfki_a0", 2, [21969, 1998, 1998, 1998, 1998]),
        ("staubli_tx40", 6, [22500, 7500, 15000]),
        ("franka_panda", 7, [8841, 7411, 2102, 2190]),
    ],
)
def test_reads_the_measured_sets(name, joints, rows):
    dataset = read_dataset(SHARED_DATA / name)
    assert dataset.robot.n == joints
    assert [len(r) + left_out(r) for r in dataset.recordings] == rows
    assert dataset.unused == ()


def test_missing_folder(tmp_path):
    assert "no such folder" in str(refused(tmp_path / "absent"))


@pytest.mark.parametrize("name", ["dataset.toml", "estimation.csv"])
def test_missing_file(tmp_path, name):
    folder = write_files(tmp_path, tiny_files())
    (folder / name).unlink()
    error = refused(folder)
    assert error.file.endswith(name)
    assert "missing" in str(error)


@pytest.mark.parametrize("robot", ["absent.urdf", ".", "builtin:nobody", "x\\u0000y"])
def test_missing_robot(tmp_path, robot):
    assert refused(spoil(tmp_path, "dataset.toml", "builtin:imi_scara", robot)).column == "robot"


def test_a_robot_file_that_is_no_urdf(tmp_path):
    folder = with_urdf(tmp_path, 2)
    (folder / "robot.urdf").write_text("<robot")
    assert refused(folder).column == "robot"


def test_a_robot_file_that_contradicts_itself(tmp_path):
    folder = with_urdf(tmp_path, 2)
    text = (folder / "robot.urdf").read_text()
    text = text.replace('lower="-3" upper="3"', 'lower="3" upper="-3"', 1)
    (folder / "robot.urdf").write_text(text)
    error = refused(folder)
    assert error.column == "robot"
    assert "lower limit 3 is above" in str(error)


def test_placeholder_inertias_do_not_stop_a_data_set(tmp_path):
    folder = with_urdf(tmp_path, 2)
    text = (folder / "robot.urdf").read_text()
    (folder / "robot.urdf").write_text(text.replace('mass value="1"', 'mass value="-1"'))
    assert len(read_dataset(folder).robot.inertia_faults) == 2


def test_joint_that_the_robot_lacks(tmp_path):
    folder = with_urdf(tmp_path, 2)
    text = (folder / "dataset.toml").read_text().replace("joint_2", "elbow")
    (folder / "dataset.toml").write_text(text)
    error = refused(folder)
    assert error.column == "joints"
    assert "elbow" in str(error)


def test_urdf_with_more_joints_than_the_manifest(tmp_path):
    error = refused(with_urdf(tmp_path, 3))
    assert error.column == "joints"
    assert "lists 2" in str(error)
    assert "has 3" in str(error)


def test_urdf_with_fewer_joints_than_the_manifest(tmp_path):
    assert refused(with_urdf(tmp_path, 1)).column == "joints"


def test_the_same_file_by_two_paths(tmp_path):
    folder = spoil(tmp_path, "dataset.toml", 'file = "test.csv"', 'file = "link.csv"')
    (folder / "link.csv").symlink_to(folder / "estimation.csv")
    assert "same file" in str(refused(folder))


def with_still_joint(folder: Path, position: float) -> Path:
    """Three joints, of which the second stands at `position` [rad]."""
    files = tiny_files()
    files["dataset.toml"] = (
        MANIFEST.replace("builtin:imi_scara", "robot.urdf")
        .replace('"joint_2"', '"joint_2", "joint_3"')
        .encode()
    )
    files["robot.urdf"] = urdf_text(3).encode()
    for name in ("estimation.csv", "test.csv"):
        frame = pd.DataFrame({"t": np.arange(40) * 0.075})
        for j, amplitude in enumerate((1.0, 0.0, 0.5)):
            frame[f"q_{j + 1}"] = amplitude * np.sin(2 * np.pi * frame["t"]) + (
                position if j == 1 else 0
            )
        frame[["tau_1", "tau_2", "tau_3"]] = np.arange(120.0).reshape(40, 3)
        frame[["temperature_1", "temperature_2", "temperature_3"]] = (21.0, 22.0, 23.0)
        write_files(folder, files)
        files[name] = frame.to_csv(index=False).encode()
    return write_files(folder, files)


def test_chosen_joints_come_in_the_order_chosen_and_the_others_are_locked(tmp_path):
    folder = with_still_joint(tmp_path, 0.5)
    dataset = read_dataset(folder, joints=["joint_3", "joint_1"])
    assert dataset.robot.joint_names == ("joint_3", "joint_1")
    assert dataset.robot.locked == ("joint_2",)
    assert dataset.estimation[0].tau[1].tolist() == [5.0, 3.0]
    assert dataset.estimation[0].temperature is not None
    assert dataset.estimation[0].temperature[1].tolist() == [23.0, 21.0]
    # The third joint is carried by the first through a link bent by the locked angle.
    third = dataset.robot.joints[0]
    assert third.parent == 1
    elbow = np.array([0.3 + 0.3 * np.cos(0.5), 0.3 * np.sin(0.5), 0.0])
    assert np.allclose(third.p_PJ, elbow, rtol=0, atol=1e-12)


def test_a_joint_that_moves_cannot_be_left_out(tmp_path):
    error = refused(with_still_joint(tmp_path, 0.0), joints=["joint_1", "joint_2"])
    assert error.column == "q_3"
    assert "moves" in str(error)


@pytest.mark.parametrize("joints", [["nobody"], [], ["joint_1", "joint_1"]])
def test_joints_that_cannot_be_chosen(tmp_path, joints):
    assert refused(with_still_joint(tmp_path, 0.0), joints=joints).column == "joints"
