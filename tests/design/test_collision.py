"""Distances and their slopes are those of geometry; what cannot be checked is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from jaxtyping import Float
from numpy import ndarray

from oed.design.collision import FAR, Surroundings
from oed.design.scene import load_scene
from oed.errors import RobotError
from oed.robot import JointLimits, imi_scara, load_robot
from tests.design.primitive_arm import (
    LENGTH,
    TIP,
    arm_and_post,
    box,
    elbow_at,
    planar_arm,
    sphere,
    tip_at,
    to_post,
)

PAIR = ("base", "lower")


def postures(count: int, seed: int = 0) -> Float[ndarray, "postures 2"]:
    return np.random.default_rng(seed).uniform(-3.0, 3.0, (count, 2))


def numeric_slope(surroundings: Surroundings, q: ndarray, pair: tuple[str, str]) -> ndarray:
    step = 1e-5
    return np.array(
        [
            (surroundings.distances(q + d)[pair] - surroundings.distances(q - d)[pair]) / 2 / step
            for d in step * np.eye(len(q))
        ]
    )


def test_two_spheres_are_as_near_as_their_centres_say(tmp_path: Path) -> None:
    surroundings = Surroundings(arm_and_post(tmp_path))
    truth = [to_post(q) for q in postures(200)]
    found = [surroundings.distances(q).get(PAIR) for q in postures(200)]
    is_near = np.array(truth) < FAR
    assert 20 < is_near.sum() < 180
    assert min(truth) < 0.0
    for near, expected, distance in zip(is_near, truth, found, strict=True):
        assert distance == (pytest.approx(expected, abs=1e-9) if near else None)


def test_a_sphere_and_a_box_are_as_near_as_the_nearest_point_of_the_box(tmp_path: Path) -> None:
    centre, half = np.array([0.0, 0.8, 0.0]), np.array([0.3, 0.1, 0.2])
    robot = planar_arm(
        tmp_path, base=box("0.6 0.2 0.4", "0 0.8 0"), lower=sphere(TIP, f"{LENGTH} 0 0")
    )
    surroundings, seen = Surroundings(robot), 0
    for q in postures(200):
        truth = np.linalg.norm(np.maximum(np.abs(tip_at(q) - centre) - half, 0.0)) - TIP
        if truth < FAR and truth > -TIP:
            seen += 1
            assert surroundings.distances(q)[PAIR] == pytest.approx(truth, abs=1e-8)
    assert seen > 20


def test_of_two_bodies_the_nearest_shapes_count(tmp_path: Path) -> None:
    posts = sphere(0.1, "0 0.8 0") + sphere(0.1, "0.3 0.8 0")
    surroundings = Surroundings(
        planar_arm(tmp_path, base=posts, lower=sphere(TIP, f"{LENGTH} 0 0"))
    )
    for q in postures(100):
        to = [np.linalg.norm(tip_at(q) - c) - 0.1 - TIP for c in ([0, 0.8, 0], [0.3, 0.8, 0])]
        if min(to) < FAR:
            assert surroundings.distances(q)[PAIR] == pytest.approx(min(to), abs=1e-9)


@pytest.mark.parametrize("shape", [sphere(0.12, "0.1 0.75 0.05"), box("0.3 0.2 0.2", "0.1 0.8 0")])
def test_slopes_are_those_of_finite_differences(shape: str, tmp_path: Path) -> None:
    robot = planar_arm(tmp_path, base=shape, lower=sphere(TIP, f"{LENGTH} 0 0"))
    surroundings = Surroundings(robot, np.array([[-0.6, 0.7], [-0.55, 0.6], [-1.0, 1.0]]))
    seen: dict[tuple[str, str], int] = {}
    for q in postures(150):
        for near in surroundings.near(q):
            if 0.01 < near.distance < FAR - 0.01:
                expected = numeric_slope(surroundings, q, near.pair)
                np.testing.assert_allclose(near.slope, expected, atol=2e-6)
                seen[near.pair] = seen.get(near.pair, 0) + 1
    assert seen[PAIR] > 5
    assert any("wall" in pair[1] for pair in seen)


def test_slopes_of_spheres_that_overlap(tmp_path: Path) -> None:
    surroundings = Surroundings(arm_and_post(tmp_path))
    overlapping = [q for q in postures(1000) if -0.1 < to_post(q) < -0.001]
    assert len(overlapping) > 5
    for q in overlapping:
        (near,) = surroundings.near(q)
        np.testing.assert_allclose(near.slope, numeric_slope(surroundings, q, PAIR), atol=2e-6)


def test_columns_follow_the_robots_order_of_joints(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path, joints=("elbow", "shoulder"))
    surroundings = Surroundings(robot)
    (near,) = surroundings.near(np.array([0.4, 1.2]))
    assert near.distance == pytest.approx(to_post(np.array([1.2, 0.4])), abs=1e-9)
    expected = numeric_slope(surroundings, np.array([0.4, 1.2]), PAIR)
    np.testing.assert_allclose(near.slope, expected, atol=2e-6)


def test_a_joint_that_is_held_stands_where_it_is_held(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path, joints=("shoulder",), locked={"elbow": 0.4})
    (near,) = Surroundings(robot).near(np.array([1.2]))
    assert near.distance == pytest.approx(to_post(np.array([1.2, 0.4])), abs=1e-9)


def test_walls_are_as_far_as_the_bodies_origins(tmp_path: Path) -> None:
    walls = np.array([[-0.2, 0.4], [-0.3, 0.35], [-5.0, 5.0]])
    surroundings = Surroundings(planar_arm(tmp_path), walls)
    for q in postures(50):
        expected = {}
        # The frame of each link is where its own joint is; the base moves with no joint.
        for body, at in (("upper", np.zeros(3)), ("lower", elbow_at(q))):
            for axis, name in enumerate("xyz"):
                expected[body, f"{name} lower wall"] = at[axis] - walls[axis, 0]
                expected[body, f"{name} upper wall"] = walls[axis, 1] - at[axis]
        near = {pair: room for pair, room in expected.items() if room <= FAR}
        assert surroundings.distances(q) == pytest.approx(near, abs=1e-12)


def test_links_that_always_overlap_are_not_judged_but_named(tmp_path: Path) -> None:
    # Spheres about base and elbow reach each other at any angle; the post is a stranger.
    base = sphere(0.3) + sphere(0.1, "0 0 0.35")
    surroundings = Surroundings(planar_arm(tmp_path, base=base, lower=sphere(0.3)))
    assert surroundings.unjudged == ("base and lower overlap in nearly all postures",)
    assert "not judged: base and lower overlap in nearly all postures" in surroundings.note
    assert not surroundings.is_judged
    assert surroundings.distances(np.zeros(2)) == {}


def test_links_that_cannot_keep_the_clearance_keep_half_of_what_they_can(tmp_path: Path) -> None:
    # Base and elbow are 1.2 cm apart at any angle.
    robot = planar_arm(tmp_path, base=sphere(0.238), lower=sphere(0.25))
    near = Surroundings(robot, clearance=0.02)
    assert near.wanted(PAIR) == pytest.approx(0.006)
    assert "base and lower 6.0 mm" in near.note
    assert near.spare(np.ones(2)) == pytest.approx(0.006)
    # They are held to a clearance of which they have twice as much, like any others.
    far = Surroundings(robot, clearance=0.005)
    assert far.wanted(PAIR) == 0.005
    assert far.note == ""


def test_a_pair_that_overlaps_in_most_postures_is_judged(tmp_path: Path) -> None:
    # A post that the tip overlaps wherever the elbow is not folded, and at mid-range.
    robot = planar_arm(tmp_path, base=sphere(0.9), lower=sphere(TIP, f"{LENGTH} 0 0"))
    q = np.random.default_rng(5).uniform(-3.0, 3.0, (500, 2))
    overlap = [np.linalg.norm(tip_at(x)) < 0.9 + TIP for x in q]
    assert 0.5 < np.mean(overlap) <= 1.0
    robot = planar_arm(tmp_path, base=sphere(0.7), lower=sphere(TIP, f"{LENGTH} 0 0"))
    surroundings = Surroundings(robot)
    assert surroundings.wanted(PAIR) == 0.01
    assert surroundings.distances(np.array([0.0, 2.0]))[PAIR] < 0.0


def test_what_no_joint_of_the_design_moves_is_not_judged(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text("""<mujoco model="arm"><worldbody>
<geom name="post" type="sphere" size="0.1" pos="0 0.25 0"/>
<body name="a"><joint name="j1" axis="0 0 1" range="-90 90"/>
<body name="b"><joint name="j2" axis="0 0 1" range="-90 90"/>
<geom type="sphere" size="0.1"/>
<body name="c"><joint name="j3" type="slide" axis="1 0 0" range="0 1"/>
<geom type="sphere" size="0.1" pos="0.25 0.25 0"/>
</body></body></body></worldbody></mujoco>""")
    strangers = {("b", "world"): pytest.approx(0.05), ("c", "world"): pytest.approx(0.05)}
    assert Surroundings(load_robot(tmp_path / "arm.xml")).distances(np.zeros(3)) == strangers
    held = Surroundings(load_robot(tmp_path / "arm.xml", joints=("j3",)))
    assert held.distances(np.zeros(1)) == {("c", "world"): pytest.approx(0.05)}


def test_no_distance_changes_by_more_than_the_reaches_say(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    surroundings = Surroundings(robot, np.array([[-0.6, 0.7], [-0.55, 0.6], [-1.0, 1.0]]))
    rng, shares = np.random.default_rng(3), []
    for q in postures(300):
        move = rng.normal(0.0, 0.05, 2)
        before, after = surroundings.distances(q), surroundings.distances(q + move)
        for pair in before.keys() & after.keys():
            most = surroundings.drift(pair) @ np.abs(move)
            shares.append(abs(after[pair] - before[pair]) / most)
            assert most <= surroundings.drift(None) @ np.abs(move) + 1e-12
    assert max(shares) <= 1.0
    assert max(shares) > 0.5  # and they are no wild guess


def test_a_builtin_robot_has_no_geometry() -> None:
    for look in (Surroundings, load_scene):
        with pytest.raises(RobotError, match="does not come from a file"):
            look(imi_scara())


def test_refuses_positions_without_limits(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path).with_limits(JointLimits.unlimited(2))
    with pytest.raises(ValueError, match="finite position limits"):
        Surroundings(robot)
