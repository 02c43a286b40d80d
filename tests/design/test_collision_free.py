"""Ranges in which collisions are rare, and motions that are moved clear of them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from jaxtyping import Float
from numpy import ndarray

from oed.design.clear_limits import ClearLimits, NoClearRange, clear_limits
from oed.design.collision import CLEARANCE, Surroundings
from oed.design.collision_free import (
    ROUNDS,
    NoClearMotion,
    _short_distances,
    avoid_collision,
)
from oed.design.default_limits import with_default_limits
from oed.design.design import Design
from oed.design.optimisers.result import OptimiserResult
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass, HarmonicClass
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.robot import JointLimits, Robot
from tests.design.primitive_arm import arm_and_post, elbow_at, planar_arm, to_post

HORIZON = 10.0
FINE = np.linspace(0.0, HORIZON, 7001)  # many more instants than a motion is built with
CLEAR = np.zeros(2)  # a posture far from the post


def narrowed(robot: Robot, box: ndarray | None = None) -> ClearLimits:
    return clear_limits(robot.limits, Surroundings(robot, box), np.random.default_rng(0))


def random_postures(limits: JointLimits) -> Float[ndarray, "postures 2"]:
    lower, upper = limits.position.T
    return np.random.default_rng(99).uniform(lower, upper, (20_000, 2))


def problem_of(robot: Robot, **given) -> DesignProblem:
    robot, _ = with_default_limits(robot)
    model = TorqueModel.standard(robot)
    trajectory = FourierClass(HORIZON, robot.limits)
    instants = trajectory.instants(40)
    return DesignProblem(model, base_parameters(model), trajectory, robot.limits, instants, **given)


def starts(problem: DesignProblem, *, hits_post: bool) -> ndarray:
    """The first random motion that does, or does not, come near the post."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        z = problem.random_start(rng)
        least = to_post(problem.trajectory.motion(z, FINE).q).min()
        if least < -0.03 if hits_post else least > 0.05:
            return z
    raise AssertionError("no such motion among 200")


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
    with pytest.raises(NoClearRange, match="check the box"):
        narrowed(planar_arm(tmp_path), np.array([[5.0, 6.0], [-1.0, 1.0], [-1.0, 1.0]]))


def test_the_same_seed_gives_the_same_range(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    np.testing.assert_array_equal(narrowed(robot).factors, narrowed(robot).factors)


def test_a_motion_is_moved_clear_and_keeps_its_limits(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    problem = problem_of(robot)
    z = starts(problem, hits_post=True)
    found = avoid_collision(problem, z, Surroundings(robot), CLEAR)
    design = Design.from_result(problem, OptimiserResult(found.z, 0.0, (), 0, 0.0, "moved"))
    # As near as is allowed and no farther: the nearest motion that keeps its distance.
    assert 0.0 < to_post(design.motion(FINE).q).min() < 1.5 * CLEARANCE
    assert design.certificate.violation <= 0.0
    # The certificate is believed only as far as the motion itself bears it out.
    assert np.abs(design.motion(FINE).q).max() <= 3.0
    assert np.abs(design.motion(FINE).dq).max() <= 2.0
    # As little as that takes: most of the motion is still there.
    before, after = (problem.trajectory.motion(x, FINE).q for x in (z, design.z))
    assert np.std(after, axis=0) == pytest.approx(np.std(before, axis=0), rel=0.6)
    assert 0 < found.rounds < ROUNDS
    assert found.factor == 1.0


def test_a_posture_on_a_linearised_bound_has_the_distance_that_is_wanted(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    q = random_postures(robot.limits)
    q = q[np.abs(to_post(q) - CLEARANCE) < 0.01][:50]
    short, is_clear = _short_distances(Surroundings(robot), q)
    assert len(short) == 50
    assert not is_clear
    for each in short:
        lacking = each.bound - each.slope @ q[each.instant]
        moved = q[each.instant] + each.slope * lacking / (each.slope @ each.slope)
        # A step of a hundredth of a radian or so is linear to a ten-thousandth or so.
        if np.linalg.norm(each.slope) > 0.3:
            assert to_post(moved) == pytest.approx(CLEARANCE, abs=1.5e-3)


def test_a_clear_motion_stays_as_it_is(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    problem = problem_of(robot)
    z = starts(problem, hits_post=False)
    found = avoid_collision(problem, z, Surroundings(robot), CLEAR)
    np.testing.assert_array_equal(found.z, z)
    assert (found.rounds, found.factor) == (0, 1.0)


def test_a_motion_shrinks_into_the_clear_posture_where_programs_do_not_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("oed.design.collision_free.ROUNDS", 0)
    robot = arm_and_post(tmp_path)
    problem = problem_of(robot)
    z = starts(problem, hits_post=True)
    found = avoid_collision(problem, z, Surroundings(robot), CLEAR)
    assert found.factor < 1.0
    assert to_post(problem.trajectory.motion(found.z, FINE).q).min() > 0.0
    assert problem.certificate(found.z).is_feasible
    # On the straight way from each position to the clear posture.
    before, after = (problem.trajectory.motion(x, FINE).q for x in (z, found.z))
    np.testing.assert_allclose(after - CLEAR, found.factor * (before - CLEAR), atol=1e-9)


def test_torque_limits_are_kept_too(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    free = problem_of(robot)
    z = starts(free, hits_post=True)
    nominal = np.zeros(len(free.model.parameters))
    nominal[: len(robot.parameters)] = robot.parameters
    motion = free.trajectory.motion(z, FINE)
    largest = np.abs(free.model.torque(nominal, motion)).max(axis=0)
    tight = free.limits.with_(torque=np.stack([-0.9 * largest, 0.9 * largest], axis=1))
    problem = dataclasses.replace(free, limits=tight, nominal=nominal)
    found = avoid_collision(problem, problem.repair(z), Surroundings(robot), CLEAR)
    design = Design.from_result(problem, OptimiserResult(found.z, 0.0, (), 0, 0.0, "moved"))
    assert design.certificate.violation <= 0.0
    moved = design.motion(FINE)
    assert to_post(moved.q).min() > 0.0
    assert (np.abs(problem.model.torque(nominal, moved)).max(axis=0) <= 0.9 * largest).all()


def test_no_motion_where_even_the_centre_collides(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("oed.design.collision_free.ROUNDS", 1)
    robot = arm_and_post(tmp_path)
    problem = problem_of(robot)
    surroundings = Surroundings(robot, np.array([[5.0, 6.0]] * 3))
    with pytest.raises(NoClearMotion):
        avoid_collision(problem, starts(problem, hits_post=False), surroundings, CLEAR)


def test_refuses_a_class_that_is_not_linear(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    linear = problem_of(robot)
    limits = linear.limits.with_(acceleration=np.tile([-8.0, 8.0], (2, 1)))
    harmonic = HarmonicClass.exact(limits, HORIZON)
    problem = dataclasses.replace(linear, trajectory=harmonic, instants=harmonic.instants(40))
    z = harmonic.draw(np.random.default_rng(0))
    with pytest.raises(ValueError, match="linear"):
        avoid_collision(problem, z, Surroundings(robot), CLEAR)
