"""What is proven of a motion's distances holds at all times, by spheres of known places."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from jaxtyping import Float
from numpy import ndarray

from oed.design.clearance import ROUNDING, ClearanceCheck, Nearest, prove_clearance
from oed.design.collision import Surroundings
from oed.design.trajectories import FourierClass
from oed.robot import Robot
from tests.design.primitive_arm import arm_and_post, elbow_at, planar_arm, to_post

HORIZON = 3.0
FINE = np.linspace(0.0, HORIZON, 20_001)


def proven(robot: Robot, z: ndarray, **given) -> ClearanceCheck:
    trajectory = FourierClass(HORIZON, robot.limits, harmonics=3)
    return prove_clearance(Surroundings(robot, **given), trajectory, z)


def positions(robot: Robot, z: ndarray) -> Float[ndarray, "samples 2"]:
    return FourierClass(HORIZON, robot.limits, harmonics=3).motion(z, FINE).q


def bodies(check: ClearanceCheck) -> Nearest:
    assert check.bodies is not None
    return check.bodies


def test_the_proven_distance_is_below_the_true_one_and_near_it(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    rng, kept = np.random.default_rng(0), 0
    for _ in range(12):
        z = rng.normal(0.0, 0.4, 14)
        truth = to_post(positions(robot, z)).min()
        found = bodies(proven(robot, z))
        spare = truth - 0.01
        assert found.spare <= spare
        if spare < ROUNDING:  # told to a millimetre or so where it is not kept
            assert found.spare > spare - 2e-3
            assert found.least == pytest.approx(truth, abs=2e-3)
            assert found.pair == ("base", "lower")
        else:
            kept += 1
            assert found.spare >= 0.0
    assert 2 < kept < 10


def test_a_millimetre_decides(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    z = np.zeros(14)
    z[7], z[8], z[13] = 0.4, 0.0, 0.0
    z[0], z[1] = -0.45, 1.62
    q = positions(robot, z)
    truth = to_post(q)
    assert bodies(proven(robot, z, clearance=truth.min() + 1e-3)).spare < 0.0
    assert bodies(proven(robot, z, clearance=truth.min() - 1e-3)).spare >= 0.0


def test_the_time_of_the_nearest_is_told(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    z = np.zeros(14)
    z[0], z[1], z[7] = 0.2, 1.2, 0.3
    distance = to_post(positions(robot, z))
    assert distance.min() < 0.1
    found = bodies(proven(robot, z))
    assert to_post(FourierClass(HORIZON, robot.limits, 3).motion(z, np.array([found.time])).q) == (
        pytest.approx(found.least, abs=1e-9)
    )


def test_walls_are_proven_apart_from_bodies(tmp_path: Path) -> None:
    robot = planar_arm(tmp_path)
    z = np.zeros(14)
    z[1] = 1.0
    box = np.array([[-0.6, 0.7], [-0.42, 0.6], [-1.0, 1.0]])
    check = proven(robot, z, box=box)
    assert check.bodies is None  # there are no shapes
    room = elbow_at(positions(robot, z))[:, 1].min() + 0.42
    assert check.walls is not None
    assert check.walls.spare <= room - 0.01
    assert check.walls.spare == pytest.approx(room - 0.01, abs=2e-3)
    assert not check.is_kept
    wide = proven(robot, z, box=box + np.array([[-1.0, 1.0]]))
    assert wide.is_kept
    assert wide.walls is not None
    assert wide.walls.least is None


@pytest.mark.parametrize("clearance", [0.0, 0.02])
def test_the_clearance_is_what_is_asked_for(clearance: float, tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    z = np.zeros(14)
    z[0], z[7] = 1.3, -0.5
    z[1] = 0.1
    truth = to_post(positions(robot, z)).min()
    found = bodies(proven(robot, z, clearance=clearance))
    assert (found.spare >= 0.0) == (truth - clearance >= ROUNDING)


def test_a_robot_without_shapes_is_not_checked(tmp_path: Path) -> None:
    check = proven(planar_arm(tmp_path), np.zeros(14))
    assert check.instants == 0
    assert check.bodies is None
    assert "no shapes" in check.note
