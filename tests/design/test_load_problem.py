"""Motions and postures that tell what an arm holds."""

import dataclasses

import numpy as np
import pytest

from oed.design.bound.least_deviation import DeviationSearch, least_deviation
from oed.design.default_limits import with_default_limits
from oed.design.default_problem import ProblemSettings, default_problem
from oed.design.known_arm import KnownTorqueModel
from oed.design.load_problem import load_model, load_problem
from oed.design.optimisers.interior_point import optimise
from oed.design.optimisers.result import Budget
from oed.design.static_poses import static_poses
from oed.dynamics.effects import Coulomb
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.errors import NoUsableResult
from oed.robot import load_robot

ROBOT, _ = with_default_limits(load_robot("builtin:imi_scara", gravity=(0.0, -9.81, 0.0)))
ARM = default_problem(
    build_model("standard", ROBOT), ProblemSettings(horizon=3.0, instants=60)
).problem


@pytest.fixture(scope="module")
def problem():
    return load_problem(ARM, 1, None)


MASS = "load_m_2"


def mass_deviation(problem, z):
    k = problem.base.names.index(MASS)
    return np.sqrt(np.linalg.inv(problem.information(z, scaled=False))[k, k])


def test_the_slope_of_the_criterion_is_that_of_finite_differences(problem):
    z = problem.random_start(np.random.default_rng(1))
    _, slope = problem.cost_and_gradient(z, sign_width=0.1)
    for k in range(0, len(z), 5):
        step = np.zeros(len(z))
        step[k] = 1e-5
        ahead, behind = (problem.cost_and_gradient(z + s, sign_width=0.1)[0] for s in (step, -step))
        assert slope[k] == pytest.approx((ahead - behind) / 2e-5, rel=1e-3, abs=1e-5)


def test_a_designed_motion_tells_more_than_random_ones_and_keeps_its_limits(problem):
    rng = np.random.default_rng(0)
    starts = [problem.random_start(rng) for _ in range(5)]
    found = problem.repair(optimise(problem, Budget(150, 60.0), rng).z)
    # In decades of the summed variances.
    assert problem.cost(found) < min(problem.cost(z) for z in starts) - 0.1
    assert problem.certificate(found).is_feasible


def known_to(variance):
    """The arm with usual friction, every parameter known to a variance."""
    model = build_model("standard", ROBOT)
    count = len(model.parameters)
    parameters = np.zeros(count)
    parameters[[e.joint * 2 + 20 for e in model.effects if isinstance(e, Coulomb)]] = 2.0
    return KnownTorqueModel(model, parameters, variance * np.eye(count))


def test_an_arm_that_is_known_badly_tells_less(problem):
    z = problem.random_start(np.random.default_rng(2))
    exact, loose = (load_problem(ARM, 1, known_to(variance)) for variance in (1e-8, 0.1))
    assert mass_deviation(loose, z) > 1.5 * mass_deviation(exact, z)


def test_errors_of_the_arm_do_not_average_out():
    """However often a motion is repeated, a load is known no better than the link that holds it."""
    variance = 0.1
    often = dataclasses.replace(ARM, instants=np.tile(ARM.instants, 1000))
    loose = load_problem(often, 1, known_to(variance))
    z = loose.random_start(np.random.default_rng(2))
    covariance = np.linalg.inv(loose.information(z, scaled=False))
    assert np.all(np.diag(covariance) > 0.9 * variance)


def test_the_bound_holds_for_every_motion_and_follows_the_length(problem):
    k = problem.base.names.index(MASS)
    search = DeviationSearch(first=400, rounds=4, drawn=1000, kept=100)
    bound = least_deviation(problem, k, np.random.default_rng(0), search)
    assert bound.lower <= bound.reached
    assert bound.lower > 0.9 * bound.reached
    rng = np.random.default_rng(3)
    starts = [problem.random_start(rng) for _ in range(5)]
    found = problem.repair(optimise(problem, Budget(150, 60.0), rng).z)
    for z in (*starts, found):
        assert mass_deviation(problem, z) > bound.lower
    longer = dataclasses.replace(problem, instants=np.tile(problem.instants, 4))
    assert least_deviation(longer, k, np.random.default_rng(0), search).reached < bound.lower


def test_a_slower_problem_keeps_to_a_slower_arm(problem):
    slow = problem.slower(0.5)
    assert slow.trajectory.horizon == pytest.approx(2 * problem.trajectory.horizon)
    assert slow.arm.trajectory is slow.trajectory


def test_postures_tell_mass_and_centre_better_than_random_ones():
    problem = load_problem(ARM, 1, known_to(1e-8))
    variance = np.asarray(problem.covariance)
    q = static_poses(problem, 1, 6, np.random.default_rng(0))
    assert np.all((q >= ROBOT.limits.position[:, 0]) & (q <= ROBOT.limits.position[:, 1]))

    def worth(q):
        still = np.zeros_like(q)
        motion = Motion(np.arange(len(q)) * 1.0, q, still, still)
        rows = load_model(ROBOT, 1).columns(motion)[:, :, :3] / np.sqrt(variance)[:, None]
        return np.linalg.slogdet(np.einsum("kjp,kjq->pq", rows, rows))[1]

    lower, upper = ROBOT.limits.position.T
    rng = np.random.default_rng(1)
    assert worth(q) > max(worth(rng.uniform(lower, upper, (6, 2))) for _ in range(20))


def test_an_arm_that_moves_level_tells_no_weight():
    level, _ = with_default_limits(load_robot("builtin:imi_scara"))
    arm = default_problem(build_model("standard", level), ProblemSettings(horizon=3.0)).problem
    with pytest.raises(NoUsableResult, match="no joint feels"):
        static_poses(load_problem(arm, 1, None), 1, 4, np.random.default_rng(0))
