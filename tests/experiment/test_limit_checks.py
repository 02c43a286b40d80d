"""Limits and torques in another unit than the robot's file are refused, outliers are told."""

import numpy as np
import pandas as pd
import pytest

from oed.experiment.read_dataset import read_dataset
from tests.experiment.tiny_dataset import refused, with_urdf

LIMITS = '[limits]\nposition = {}\n[[recording]]\nfile = "est'


def with_position_limits(tmp_path, position):
    """The tiny data set with position limits of its own, besides those of its robot's file."""
    folder = with_urdf(tmp_path, 2)
    stated = LIMITS.format(position)
    manifest = folder / "dataset.toml"
    manifest.write_text(manifest.read_text().replace('[[recording]]\nfile = "est', stated))
    return folder


@pytest.mark.parametrize("position", ["[[-150, 150], [-2, 2]]", "[[-1, 1], [-90, 9]]"])
def test_position_limits_in_degrees(tmp_path, position):
    error = refused(with_position_limits(tmp_path, position))
    assert error.column == "limits.position"
    assert "looks like degrees" in str(error)


@pytest.mark.parametrize("position", ["[[-6, 6], [-2, 2]]", "[[-inf, inf], [-2, 2]]"])
def test_position_limits_somewhat_beyond_those_of_the_file_are_believed(tmp_path, position):
    folder = with_position_limits(tmp_path, position)
    assert read_dataset(folder).robot.limits.position[1].tolist() == [-2, 2]


def with_torque(tmp_path, change):
    """The tiny data set whose joints may give 10 N m, with the torque of test.csv changed."""
    folder = with_urdf(tmp_path, 2)
    frame = pd.read_csv(folder / "test.csv")
    frame["tau_2"] = change(frame["tau_2"].to_numpy())
    frame.to_csv(folder / "test.csv", index=False)
    return folder


def test_torque_in_another_unit(tmp_path):
    error = refused(with_torque(tmp_path, lambda tau: 1e3 * tau))
    assert error.file.endswith("test.csv")
    assert error.column == "tau_2"
    assert "times the limit of joint 'joint_2', 10 N m" in str(error)
    assert "N mm" in str(error)


def test_single_samples_beyond_what_a_drive_can_give_are_told(tmp_path):
    def spiked(tau):
        return np.where(
            np.isin(np.arange(len(tau)), [4, 7]), [200.0 + k for k in range(len(tau))], tau
        )

    dataset = read_dataset(with_torque(tmp_path, spiked))
    (note,) = dataset.notes
    assert "test.csv, row 9, column 'tau_2': |tau| = 207" in note
    assert "2 of 30 samples" in note


def test_many_samples_beyond_a_limit_are_no_outliers(tmp_path):
    (note,) = read_dataset(with_torque(tmp_path, lambda tau: 70 * tau)).notes
    assert "too many for outliers" in note
    assert "state [limits] torque" in note
    assert "remove them" not in note


def test_one_value_that_is_no_torque_is_named_by_its_row(tmp_path):
    def marked(tau):
        return np.where(np.arange(len(tau)) == 11, -1e6, tau)

    error = refused(with_torque(tmp_path, marked))
    assert error.row == 13
    assert error.column == "tau_2"
    assert "|tau| = 1e+06" in str(error)
    assert "N mm" not in str(error)


def test_torque_within_the_limits_needs_no_word(tmp_path):
    assert read_dataset(with_torque(tmp_path, lambda tau: 25 * tau)).notes == ()
