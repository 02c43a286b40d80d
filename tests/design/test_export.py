"""What is written is what was designed."""

import json

import numpy as np
import pytest

from oed.design.export import (
    SetPoints,
    write_csv,
    write_joint_trajectory_json,
    write_joint_trajectory_yaml,
)
from tests.design.problems import HORIZON, classes, scara

ROBOT, *_ = scara()
TRAJECTORY = classes(ROBOT.limits)["fourier"]
Z = TRAJECTORY.draw(np.random.default_rng(0))


def points(rate: float) -> SetPoints:
    return SetPoints.sample(TRAJECTORY, Z, ROBOT.joint_names, rate)


def test_csv_reads_back_exactly(tmp_path) -> None:
    write_csv(points(50.0), tmp_path / "motion.csv")
    header, *_ = (tmp_path / "motion.csv").read_text().splitlines()
    assert header == "t,q_joint_1,q_joint_2,dq_joint_1,dq_joint_2,ddq_joint_1,ddq_joint_2"
    table = np.loadtxt(tmp_path / "motion.csv", delimiter=",", skiprows=1)
    assert len(table) == 501
    motion = TRAJECTORY.motion(Z, table[:, 0])
    np.testing.assert_array_equal(table[:, 1:3], motion.q)
    np.testing.assert_array_equal(table[:, 5:], motion.ddq)


def test_joint_trajectories_say_the_same_in_json_and_yaml(tmp_path) -> None:
    write_joint_trajectory_json(points(20.0), tmp_path / "a.json")
    write_joint_trajectory_yaml(points(20.0), tmp_path / "a.yaml")
    message = json.loads((tmp_path / "a.json").read_text())
    yaml = pytest.importorskip("yaml")
    assert yaml.safe_load((tmp_path / "a.yaml").read_text()) == message
    last = message["points"][-1]
    assert last["time_from_start"] == {"sec": 10, "nanosec": 0}
    np.testing.assert_array_equal(
        last["positions"], TRAJECTORY.derivative(Z, np.array([HORIZON]), 0)[0]
    )


def test_the_end_is_kept_where_the_rate_does_not_divide_the_horizon() -> None:
    t = points(0.3).motion.t
    assert t[-1] == HORIZON
    assert (np.diff(t) > 0).all()


def test_refuses_a_rate_that_is_not_positive() -> None:
    with pytest.raises(ValueError, match="not positive"):
        points(0.0)
