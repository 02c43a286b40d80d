"""Ranges of positions in which collisions are rare."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from jaxtyping import Float
from numpy import ndarray

from oed.design.clear_limits import ClearLimits, clear_limits
from oed.design.clear_posture import clear_posture
from oed.design.collision import Surroundings
from oed.errors import NoUsableResult
from oed.robot import JointLimits, Robot, load_robot
from tests.design.primitive_arm import (
    LENGTH,
    POST,
    TIP,
    arm_and_post,
    elbow_at,
    planar_arm,
    sphere,
    tip_at,
    to_post,
)


def narrowed(robot: Robot, box: ndarray | None = None) -> ClearLimits:
    return clear_limits(robot.limits, Surroundings(robot, box), np.random.default_rng(0))


def random_postures(limits: JointLimits) -> Float[ndarray, "postures 2"]:
    lower, upper = limits.position.T
    return np.random.default_rng(99).uniform(lower, upper, (20_000, 2))


def test_collisions_are_rare_within_the_narrowed_range(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path, post=0.4, reach=(2.5, 2.0))
    assert (to_post(random_postures(robot.limits), 0.4) < 0).mean() > 0.15
    room = narrowed(robot)
    # Two in a hundred among at least 200 postures: three standard deviations above is 0.05.
    assert (to_post(random_postures(room.limits), 0.4) < 0).mean() < 0.05


def test_the_range_is_a_share_of_the_given_one_about_a_clear_centre(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    room = narrowed(robot)
    given = robot.limits.position
    assert to_post(room.centre) > 0
    assert (room.limits.position[:, 0] >= given[:, 0] - 1e-12).all()
    assert (room.limits.position[:, 1] <= given[:, 1] + 1e-12).all()
    share = np.diff(room.limits.position, axis=1) / np.diff(given, axis=1)
    np.testing.assert_allclose(share[:, 0], room.factors)
    np.testing.assert_array_equal(room.limits.velocity, robot.limits.velocity)


def test_the_range_stays_where_nothing_collides(tmp_path: Path) -> None:
    robot = planar_arm(tmp_path)
    room = narrowed(robot)
    np.testing.assert_array_equal(room.factors, 1.0)
    np.testing.assert_allclose(room.limits.position, robot.limits.position)


def test_the_centre_moves_where_mid_range_is_outside_the_box(tmp_path: Path) -> None:
    robot = planar_arm(tmp_path)
    wall = 0.2  # the elbow is at 0.5 in mid-range
    room = narrowed(robot, np.array([[-1.0, wall], [-1.0, 1.0], [-1.0, 1.0]]))
    assert elbow_at(robot.limits.position.mean(axis=1))[0] > wall
    assert elbow_at(room.centre)[0] < wall
    assert (elbow_at(random_postures(room.limits))[:, 0] > wall).mean() < 0.05


def test_no_range_where_the_box_cannot_hold_the_arm(tmp_path: Path) -> None:
    with pytest.raises(NoUsableResult, match="check the box"):
        narrowed(planar_arm(tmp_path), np.array([[5.0, 6.0], [-1.0, 1.0], [-1.0, 1.0]]))


def test_the_same_seed_gives_the_same_range(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    np.testing.assert_array_equal(narrowed(robot).factors, narrowed(robot).factors)


def test_joints_of_two_turns_and_links_that_are_always_near_leave_a_wide_range(
    tmp_path: Path,
) -> None:
    # Narrowing a joint of two turns to one changes nothing, and base and elbow are 1.2 cm apart
    # at any angle: neither may hide how wide the range is that the post leaves.
    at = " ".join(map(str, POST))
    robot = planar_arm(
        tmp_path, base=sphere(0.238) + sphere(0.3, at), reach=(6.28, 6.28),
        lower=sphere(0.25) + sphere(TIP, f"{LENGTH} 0 0"),
    )  # fmt: skip
    room = narrowed(robot)
    assert to_post(room.centre, 0.3) > 0.1
    assert np.diff(room.limits.position, axis=1).min() > 0.3
    assert (to_post(random_postures(room.limits), 0.3) < 0).mean() < 0.05


def test_links_that_are_near_in_any_posture_do_not_choose_one(tmp_path: Path) -> None:
    # Bodies a and c are 1.2 cm apart and no more than 1.3 cm, where the arm is stretched towards
    # a post and 2 cm from it.
    (tmp_path / "arm.xml").write_text("""<mujoco model="arm"><worldbody>
<geom name="post" type="sphere" size="0.3" pos="1 0.42 0"/>
<body name="a"><joint name="j1" axis="0 0 1" range="-6 6"/><geom type="sphere" size="0.238"/>
<body name="b" pos="0.5 0 0"><joint name="j2" axis="0 0 1" range="-50 50"/>
<body name="c"><joint name="j3" axis="0 0 1" range="-50 50"/>
<geom type="sphere" size="0.25" pos="0.001 0 0"/>
<geom type="sphere" size="0.1" pos="0.5 0 0"/>
</body></body></body></worldbody></mujoco>""")
    robot = load_robot(tmp_path / "arm.xml")
    q = clear_posture(robot.limits, Surroundings(robot), np.random.default_rng(0))
    tip = tip_at(np.array([q[0], q[1] + q[2]]))
    assert np.linalg.norm(tip - np.array([1.0, 0.42, 0.0])) - 0.1 - 0.3 > 0.2
