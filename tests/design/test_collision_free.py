"""Motions that are moved clear of collisions."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from numpy import ndarray

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
from oed.robot import Robot
from tests.design.primitive_arm import (
    arm_and_post,
    to_post,
)

HORIZON = 10.0
FINE = np.linspace(0.0, HORIZON, 7001)  # many more instants than a motion is built with


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


def test_torque_gets_dearer_with_distances_and_a_way_that_is_barred_is_given_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dearer = []

    def nowhere(_problem: DesignProblem, start: ndarray, *_, **given) -> ndarray:
        dearer.append(given["dearer"])
        return start

    monkeypatch.setattr("oed.design.collision_free.solve_near", nowhere)
    robot = arm_and_post(tmp_path)
    problem = problem_of(robot)
    z, log = starts(problem, hits_post=True), EvaluationLog(Budget(evaluations=100))
    assert descend(problem, z, Surroundings(robot), log) is None
    # Steps of 0.3, 0.1 and 0.03 at each price.
    assert dearer == [1.0, 1.0, 1.0, 10.0, 10.0, 10.0]


def test_excess_torque_costs_as_much_as_it_is_dear(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    free = problem_of(robot)
    z = starts(free, hits_post=True)
    nominal = np.zeros(len(free.model.parameters))
    nominal[: len(robot.parameters)] = robot.parameters
    tight = free.limits.with_(torque=np.array([[-1.0, 1.0], [-1.0, 1.0]]))
    problem = dataclasses.replace(free, limits=tight, nominal=nominal)
    base, slope = free.cost_and_gradient(z)
    once, push = problem.cost_and_gradient(z)
    tenfold, hard = problem.cost_and_gradient(z, dearer=10.0)
    assert once > base + 1.0
    assert tenfold - base == pytest.approx(10 * (once - base))
    np.testing.assert_allclose(hard - slope, 10 * (push - slope))


def test_evaluations_end_the_search_once_a_motion_is_clear_and_not_before(tmp_path: Path) -> None:
    robot = arm_and_post(tmp_path)
    problem = problem_of(robot)
    z, spent = starts(problem, hits_post=True), {}
    for evaluations in (0, 600):
        log = EvaluationLog(Budget(evaluations))
        found = descend(problem, z, Surroundings(robot), log)
        assert found is not None
        assert to_post(problem.trajectory.motion(found.z, FINE).q).min() > CLEARANCE - 1e-3
        spent[evaluations] = log.evaluations
    assert 0 < spent[0] < spent[600] <= 600


def test_where_no_way_leads_out_the_search_begins_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # One round is too little from a motion in the post, and enough from one clear of it.
    monkeypatch.setattr("oed.design.collision_free.ROUNDS", 1)
    robot = arm_and_post(tmp_path, post=0.3)
    problem = problem_of(robot)
    z = starts(problem, hits_post=True)
    rng = np.random.default_rng(0)
    found = find_clear_motion(
        problem, z, Surroundings(robot), EvaluationLog(Budget(evaluations=30)), rng
    )
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
    found = find_clear_motion(problem, z, surroundings, EvaluationLog(Budget(evaluations=30)), rng)
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
    log, rng = EvaluationLog(Budget(evaluations=100)), np.random.default_rng(0)
    found = find_clear_motion(problem, problem.repair(z), Surroundings(robot), log, rng)
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
        find_clear_motion(problem, z, surroundings, EvaluationLog(Budget(evaluations=30)), rng)
