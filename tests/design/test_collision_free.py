"""Ranges in which collisions are rare, and motions that are moved clear of them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from jaxtyping import Float
from numpy import ndarray

from oed.design.clear_limits import ClearLimits, clear_limits
from oed.design.clear_posture import clear_posture
from oed.design.collision import CLEARANCE, Surroundings
from oed.design.collision_free import (
    BUFFER,
    INSTANTS,
    ClearMotion,
    Distances,
    descend,
    find_clear_motion,
)
from oed.design.default_limits import with_default_limits
from oed.design.design import Design
from oed.design.optimisers.interior_point import optimise
from oed.design.optimisers.result import Budget, EvaluationLog, OptimiserResult
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
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

HORIZON = 10.0
FINE = np.linspace(0.0, HORIZON, 7001)  # many more instants than a motion is built with


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
    with pytest.raises(NoUsableResult, match="check the box"):
        narrowed(planar_arm(tmp_path), np.array([[5.0, 6.0], [-1.0, 1.0], [-1.0, 1.0]]))


def test_the_same_seed_gives_the_same_range(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    np.testing.assert_array_equal(narrowed(robot).factors, narrowed(robot).factors)


def moved(problem: DesignProblem, z: ndarray, surroundings: Surroundings) -> ClearMotion:
    log = EvaluationLog(Budget(cpu_seconds=60.0))
    found = descend(problem, z, surroundings, log)
    assert found is not None
    return found


def test_a_motion_is_moved_clear_and_keeps_its_limits(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    problem = problem_of(robot)
    z = starts(problem, hits_post=True)
    found = moved(problem, z, Surroundings(robot))
    design = Design.from_result(problem, OptimiserResult(found.z, 0.0, (), 0, 0.0, "moved"))
    assert to_post(design.motion(FINE).q).min() >= CLEARANCE - 1e-3
    assert design.certificate.violation <= 0.0
    # The certificate is believed only as far as the motion itself bears it out.
    assert np.abs(design.motion(FINE).q).max() <= 3.0
    assert np.abs(design.motion(FINE).dq).max() <= 2.0
    assert found.cost == problem.cost(found.z)
    assert found.rounds > 0


def test_what_keeping_clear_costs_is_little(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    problem = problem_of(robot)
    free = optimise(problem, Budget(evaluations=300), np.random.default_rng(0))
    assert to_post(problem.trajectory.motion(free.z, FINE).q).min() < 0.0
    found = moved(problem, free.z, Surroundings(robot))
    assert to_post(problem.trajectory.motion(found.z, FINE).q).min() > CLEARANCE - 1e-3
    # Eight parameters: a decade together is a third of the standard deviation of each.
    assert found.cost < problem.cost(free.z) + 1.0


def test_the_price_and_its_slope_are_those_of_the_distances(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    problem = problem_of(robot)
    trajectory, z = problem.trajectory, starts(problem, hits_post=True)
    seen = Distances.at(trajectory, z, Surroundings(robot))
    t = np.linspace(0.0, HORIZON, INSTANTS)
    truth = to_post(trajectory.motion(z, t).q) - CLEARANCE
    assert seen.spare == pytest.approx(truth.min(), abs=1e-9)
    x = np.maximum(1.0 - truth / BUFFER, 0.0)
    expected = 3.0 * np.where(x < 1.0, x**2, 2 * x - 1).sum() / INSTANTS
    value, slope = seen.price(z, 3.0)
    assert value == pytest.approx(expected, rel=1e-6)
    step = 1e-6
    numeric = [
        (seen.price(z + d, 3.0)[0] - seen.price(z - d, 3.0)[0]) / 2 / step
        for d in step * np.eye(len(z))
    ]
    np.testing.assert_allclose(slope, numeric, rtol=1e-3, atol=1e-6)


def test_a_clear_motion_of_least_cost_stays_clear(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    problem = problem_of(robot)
    z = starts(problem, hits_post=False)
    found = moved(problem, z, Surroundings(robot))
    assert found.cost <= problem.cost(z)
    assert to_post(problem.trajectory.motion(found.z, FINE).q).min() > CLEARANCE - 1e-3


def test_where_no_way_leads_out_the_search_begins_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # One round is too little from a motion in the post, and enough from one clear of it.
    monkeypatch.setattr("oed.design.collision_free.ROUNDS", 1)
    robot = arm_and_post(tmp_path, post=0.3)
    problem = problem_of(robot)
    z = starts(problem, hits_post=True)
    rng = np.random.default_rng(0)
    found = find_clear_motion(problem, z, Surroundings(robot), Budget(evaluations=30), rng)
    assert to_post(problem.trajectory.motion(found.z, FINE).q, 0.3).min() > CLEARANCE - 1e-3
    assert np.isfinite(found.cost)


def test_where_no_beginning_leads_out_the_range_is_halved_about_its_clear_centre(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # No way leads out of anything that is hit, and the range stays as it is: the first two hit the post.
    monkeypatch.setattr("oed.design.collision_free.ROUNDS", 0)
    monkeypatch.setattr("oed.design.clear_limits.RARE", 1.0)
    robot = arm_and_post(tmp_path, post=0.3)
    problem = problem_of(robot)
    z = starts(problem, hits_post=True)
    surroundings, rng = Surroundings(robot), np.random.default_rng(0)
    found = find_clear_motion(problem, z, surroundings, Budget(evaluations=30), rng)
    q = problem.trajectory.motion(found.z, FINE).q
    assert to_post(q, 0.3).min() > CLEARANCE - 1e-3
    assert (np.ptp(q, axis=0) <= 0.55 * np.ptp(problem.limits.position, axis=1)).all()


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
    budget, rng = Budget(evaluations=100), np.random.default_rng(0)
    found = find_clear_motion(problem, problem.repair(z), Surroundings(robot), budget, rng)
    design = Design.from_result(problem, OptimiserResult(found.z, 0.0, (), 0, 0.0, "moved"))
    assert design.certificate.violation <= 0.0
    after = design.motion(FINE)
    assert to_post(after.q).min() > 0.0
    assert (np.abs(problem.model.torque(nominal, after)).max(axis=0) <= 0.9 * largest).all()


def test_no_motion_where_no_posture_is_clear(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    problem = problem_of(robot)
    surroundings = Surroundings(robot, np.array([[5.0, 6.0]] * 3))
    z, rng = starts(problem, hits_post=False), np.random.default_rng(0)
    with pytest.raises(NoUsableResult, match="check the box"):
        find_clear_motion(problem, z, surroundings, Budget(evaluations=30), rng)


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
