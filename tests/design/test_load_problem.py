"""Motions and postures that tell what an arm holds."""

import numpy as np
import pytest

from oed.design.default_limits import with_default_limits
from oed.design.default_problem import ProblemSettings, default_problem
from oed.design.load_problem import KnownTorqueModel, load_model, load_problem
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


def mass_deviation(problem, z):
    k = problem.base.names.index("load_m_2")
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


def test_an_arm_that_is_known_badly_tells_less(problem):
    model = build_model("standard", ROBOT)
    count = len(model.parameters)
    parameters = np.zeros(count)
    parameters[[e.joint * 2 + 20 for e in model.effects if isinstance(e, Coulomb)]] = 2.0
    z = problem.random_start(np.random.default_rng(2))
    exact, loose = (
        load_problem(ARM, 1, KnownTorqueModel(model, parameters, variance * np.eye(count)))
        for variance in (0.0, 0.1)
    )
    assert mass_deviation(loose, z) > 1.5 * mass_deviation(exact, z)


def test_a_slower_problem_keeps_to_a_slower_arm(problem):
    slow = problem.slower(0.5)
    assert slow.trajectory.horizon == pytest.approx(2 * problem.trajectory.horizon)
    assert slow.arm.trajectory is slow.trajectory


def test_postures_tell_mass_and_centre_better_than_random_ones():
    variance = np.array([1.0, 0.1])
    q = static_poses(ROBOT, 1, 6, variance, np.random.default_rng(0))
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
    with pytest.raises(NoUsableResult, match="no joint feels"):
        static_poses(level, 1, 4, np.ones(2), np.random.default_rng(0))
