"""The robot of a data set, with or without recordings."""

from pathlib import Path

import numpy as np
import pytest

from oed.errors import DataSetError
from oed.experiment.read_dataset import read_dataset, read_robot
from tests.experiment.tiny_dataset import MANIFEST, refused, tiny_files, urdf_text, write_files
from tests.running import oed

BEFORE = MANIFEST.partition("[[recording]]")[0].replace("[0.0, 0.0, -9.81]", "[0.0, -9.81, 0.0]")
LIMITS = "[limits]\nvelocity = [1.5, 2.5]\n"


def before_the_first_experiment(folder: Path, more: str = LIMITS) -> Path:
    return write_files(folder, {"dataset.toml": (BEFORE + more).encode()})


def with_urdf(folder: Path) -> Path:
    manifest = (BEFORE + LIMITS).replace("builtin:imi_scara", "robot.urdf")
    urdf = urdf_text(2).encode()
    return write_files(folder, {"dataset.toml": manifest.encode(), "robot.urdf": urdf})


@pytest.mark.parametrize("more", [LIMITS, "recording = []\n" + LIMITS])
def test_the_robot_is_there_before_the_first_experiment(tmp_path: Path, more: str) -> None:
    robot = read_robot(before_the_first_experiment(tmp_path, more))
    assert robot.joint_names == ("joint_1", "joint_2")
    np.testing.assert_array_equal(robot.gravity, [0.0, -9.81, 0.0])
    np.testing.assert_array_equal(robot.limits.velocity, [[-1.5, 1.5], [-2.5, 2.5]])


def test_what_needs_recordings_refuses_a_set_without(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    data = before_the_first_experiment(tmp_path / "data")
    error = refused(data)
    assert error.column == "recording"
    assert "nothing is recorded yet" in str(error)
    for command in ("identify", "feasible", "diagnose"):
        assert oed(command, data, "--out", tmp_path / "out") == 2
        printed = capfd.readouterr()
        assert printed.err.count("\n") == 1
        assert "nothing is recorded yet" in printed.err
        assert not (tmp_path / "out").exists()


def test_recordings_are_not_read_for_the_robot(tmp_path: Path) -> None:
    files = tiny_files()
    whole = read_dataset(write_files(tmp_path / "whole", files)).robot
    robot = read_robot(write_files(tmp_path / "lost", {"dataset.toml": files["dataset.toml"]}))
    np.testing.assert_array_equal(robot.parameters, whole.parameters)
    np.testing.assert_array_equal(robot.limits.velocity, whole.limits.velocity)


def test_joints_are_chosen_with_their_limits(tmp_path: Path) -> None:
    data = with_urdf(tmp_path)
    robot = read_robot(data, joints=["joint_2"])
    assert robot.joint_names == ("joint_2",)
    np.testing.assert_array_equal(robot.limits.velocity, [[-2.5, 2.5]])
    with pytest.raises(DataSetError, match="no joint 'wrist' to choose"):
        read_robot(data, joints=["wrist"])


def test_no_folder_is_said(tmp_path: Path) -> None:
    with pytest.raises(DataSetError, match="no such folder"):
        read_robot(tmp_path / "nowhere")


def test_a_motion_is_designed_before_the_first_experiment(tmp_path: Path) -> None:
    data = before_the_first_experiment(tmp_path / "data")
    out = tmp_path / "out"
    assert oed("design", "--data", data, "--out", out, "--smoke") == 0
    assert (out / "motion.csv").exists()
    assert sorted(path.name for path in data.iterdir()) == ["dataset.toml"]
