"""A design for drawn models, against each model on its own and against Drake."""

import dataclasses

import numpy as np
import pytest

from oed.design.criteria import CRITERIA, cost, information
from oed.design.default_limits import with_default_limits
from oed.design.default_problem import ProblemSettings, default_problem
from oed.design.optimisers.interior_point import optimise
from oed.design.optimisers.random_search import optimise as random_search
from oed.design.optimisers.result import Budget
from oed.design.optimisers.warm_start import from_motion
from oed.design.robust_problem import RobustProblem, Scenario
from oed.design.robust_worth import RobustWorth, Worth, torque_of_drawn
from oed.dynamics.drake_plant import drake_torque
from oed.dynamics.effects import Coulomb
from oed.dynamics.effects.stribeck import Stribeck
from oed.dynamics.models import build_model
from oed.dynamics.scalars import magnitude, power
from oed.errors import NoUsableResult
from tests.dynamics.effects.arms import vertical_arm

SPEEDS = ((0.05, 0.3), (0.02, 0.15), (0.4, 0.1))  # of both joints, the first ones nominal [rad/s]
FRICTION = (2.0, 1.0, 1.5, 0.8)  # dry and viscous, joint by joint
EXTRA = 0.5  # [N m] at rest, of each joint
T = np.linspace(0.0, 6.0, 400)


def robot_with(torque):
    robot = with_default_limits(vertical_arm())[0]
    bounds = np.array(torque)[:, None] * (-1.0, 1.0)
    return robot.with_limits(robot.limits.with_(torque=bounds))


def problem_of(robot, *, torque, **given):
    model = build_model("standard", robot, sign_width=0.01).with_effects(
        *(Stribeck(j, v) for j, v in enumerate(SPEEDS[0]))
    )
    settings = ProblemSettings(horizon=6.0, instants=50, torque=torque, **given)
    return dataclasses.replace(default_problem(model, settings).problem, native=False)


def parameters_of(robot, heavier=1.0):
    return np.concatenate([heavier * robot.parameters, FRICTION, [EXTRA, EXTRA]])


def other_speeds(problem, speeds):
    effects = tuple(
        dataclasses.replace(e, speed=speeds[e.joint]) if isinstance(e, Stribeck) else e
        for e in problem.model.effects
    )
    return dataclasses.replace(problem.model, effects=effects)


@pytest.fixture(scope="module")
def shaped():
    """Drawn models of other Stribeck speeds, in units and with noise and knowledge of all kinds."""
    problem = problem_of(robot_with((np.inf, np.inf)), torque=False)
    rng, count = np.random.default_rng(2), len(problem.base)
    known = rng.normal(size=(count, count))
    problem = dataclasses.replace(
        problem,
        covariance=np.array([0.3, 0.02]),
        prior=known @ known.T,
        scaling=rng.uniform(0.5, 2.0, count),
    )
    own = parameters_of(problem.model.robot)
    scenarios = [Scenario(other_speeds(problem, speeds), own) for speeds in SPEEDS[1:]]
    # Of the second one only one joint's friction is another.
    effects = (*problem.model.effects[:-1], Stribeck(1, 0.7))
    scenarios.append(Scenario(dataclasses.replace(problem.model, effects=effects), own))
    return problem, scenarios


def truth(problem, scenario, z):
    """Of one model on its own: its columns by NumPy, nothing compiled and nothing shared."""
    motion = problem.trajectory.motion(z, problem.instants)
    columns = scenario.model.columns(motion)[..., problem.base.columns]
    told = information(columns, problem.covariance, problem.prior)
    return cost(told * np.outer(problem.scaling, problem.scaling), problem.criterion)


@pytest.mark.parametrize("criterion", CRITERIA)
def test_criteria_are_those_of_each_model_alone(shaped, criterion):
    problem, scenarios = shaped
    problem = dataclasses.replace(problem, criterion=criterion)
    z = problem.random_start(np.random.default_rng(0))
    every = np.array([truth(problem, each, z) for each in scenarios])
    assert np.ptp(every) > 1e-3
    expected, worst = (RobustProblem.of(problem, aim, scenarios) for aim in ("expected", "worst"))
    assert expected.costs(z) == pytest.approx(every, rel=1e-9)
    assert expected.cost(z) == pytest.approx(every.mean(), rel=1e-9)
    assert worst.cost(z) == pytest.approx(every.max(), rel=1e-9)
    # What is reported besides is the nominal model's.
    assert expected.information(z) == pytest.approx(problem.information(z), rel=1e-9)
    assert expected.alone.cost(z) == pytest.approx(problem.cost(z), rel=1e-9)


@pytest.mark.parametrize("aim", ["expected", "worst"])
@pytest.mark.parametrize("criterion", ["J_d", "J_k"])
def test_gradient_is_that_of_finite_differences(shaped, criterion, aim):
    problem, scenarios = shaped
    robust = RobustProblem.of(dataclasses.replace(problem, criterion=criterion), aim, scenarios)
    z = robust.random_start(np.random.default_rng(1))
    how = {"sign_width": 0.3, "exponent": 8.0}
    _, gradient = robust.cost_and_gradient(z, **how)
    rng = np.random.default_rng(3)
    for _ in range(3):
        way = rng.normal(size=len(z))
        high, low = (robust.cost_and_gradient(z + h * way, **how)[0] for h in (1e-6, -1e-6))
        assert gradient @ way == pytest.approx((high - low) / 2e-6, rel=1e-4, abs=1e-6)


def test_a_smooth_worst_is_above_the_worst_and_comes_to_it(shaped):
    problem, scenarios = shaped
    robust = RobustProblem.of(problem, "worst", scenarios)
    z = robust.random_start(np.random.default_rng(1))
    values = [robust.cost_and_gradient(z, sign_width=0.0, exponent=e)[0] for e in (4, 16, np.inf)]
    assert values[0] > values[1] > values[2]
    assert values[2] == pytest.approx(robust.cost(z), rel=1e-9)


@pytest.mark.parametrize("aim", ["expected", "worst"])
def test_a_search_from_a_motion_comes_to_a_better_one_for_the_drawn_models(shaped, aim):
    problem, scenarios = shaped
    robust = RobustProblem.of(dataclasses.replace(problem, criterion="J_k"), aim, scenarios)
    start = robust.random_start(np.random.default_rng(0))
    search = from_motion(random_search, start)
    found = search(robust, Budget(evaluations=60), np.random.default_rng(0))
    assert found.evaluations <= 60
    assert found.cost < robust.cost(start) - 0.1
    every = np.array([truth(robust, each, found.z) for each in scenarios])
    assert found.cost == pytest.approx(robust.combined(every))


def test_a_search_from_a_motion_is_no_worse_than_that(shaped):
    problem, scenarios = shaped
    robust = RobustProblem.of(problem, "worst", scenarios)
    best = optimise(robust, Budget(evaluations=30), np.random.default_rng(0))
    found = from_motion(random_search, best.z)(
        robust, Budget(evaluations=4), np.random.default_rng(0)
    )
    assert found.cost <= best.cost + 1e-6


@pytest.fixture(scope="module")
def heavy():
    """A nominal model, and one whose last link is heavier by half, which brakes and moves more."""
    robot = robot_with((45.0, 11.0))
    problem = problem_of(robot, torque=True)
    own = parameters_of(robot)
    own[10:20] *= 1.5
    return problem, [Scenario(problem.model, parameters_of(robot)), Scenario(problem.model, own)]


def by_drake(scenario, motion):
    """Torque of the drawn bodies by Drake, and of its friction by hand [N m]."""
    robot = scenario.model.robot
    drawn = dataclasses.replace(robot, parameters=scenario.parameters[: 10 * robot.n])
    dry, viscous = np.array(FRICTION).reshape(-1, 2).T
    falling = EXTRA * np.exp(-((motion.dq / SPEEDS[0]) ** 2))
    width = next(e.width for e in scenario.model.effects if isinstance(e, Coulomb))
    braking = dry * np.tanh(motion.dq / width) + falling * np.sign(motion.dq)
    return drake_torque(drawn, motion) + braking + viscous * motion.dq


def test_torque_limits_that_a_nominal_design_breaks_are_kept_by_a_robust_one(heavy):
    problem, scenarios = heavy
    robust = RobustProblem.of(problem, "worst", scenarios)
    nominal, found = (
        each.repair(optimise(each, Budget(evaluations=25), np.random.default_rng(0)).z)
        for each in (problem, robust)
    )
    limit = problem.limits.torque[:, 1]
    shares = [
        [
            np.abs(by_drake(s, problem.trajectory.motion(z, T)) / limit).max(axis=0)
            for s in scenarios
        ]
        for z in (nominal, found)
    ]
    assert np.max(shares[0][1]) > 1.0
    assert np.max(shares[1]) <= 1.0
    assert np.max(shares[1]) > 0.9  # and no more is given up than the limit asks for
    worth = RobustWorth.of(robust, nominal, found)
    assert worth.nominal_design.exceeding == 1 + (np.max(shares[0][0]) > 1.0)
    assert worth.robust_design.exceeding == 0
    assert worth.nominal_design.largest_share == pytest.approx(np.max(shares[0]), rel=1e-3)
    assert not problem.certificate(nominal).violation > 0
    assert robust.certificate(nominal).violation > 0
    assert robust.certificate(found).violation <= 0


def test_a_model_that_exceeds_at_two_joints_counts_once(heavy):
    problem, scenarios = heavy
    robust = RobustProblem.of(problem, "worst", scenarios)
    z = problem.random_start(np.random.default_rng(1))
    shares = [np.abs(by_drake(s, problem.trajectory.motion(z, T))).max(axis=0) for s in scenarios]
    beyond = np.array(shares) > problem.limits.torque[:, 1]
    assert beyond.sum() > beyond.any(axis=1).sum()
    assert Worth.of(robust, z).exceeding == beyond.any(axis=1).sum()


def test_the_price_of_torque_is_that_of_the_model_that_needs_most(heavy):
    problem, scenarios = heavy
    robust = RobustProblem.of(problem, "worst", scenarios)
    z = problem.random_start(np.random.default_rng(0))
    free = problem.cost_and_gradient(z)[0]
    assert robust.cost_and_gradient(z)[0] > free + 0.1
    alone = dataclasses.replace(problem, nominal=scenarios[1].parameters)
    assert robust.cost_and_gradient(z)[0] == pytest.approx(alone.cost_and_gradient(z)[0])
    rng = np.random.default_rng(3)
    way = rng.normal(size=len(z))
    high, low = (robust.cost_and_gradient(z + h * way, sign_width=0.3)[0] for h in (1e-6, -1e-6))
    gradient = robust.cost_and_gradient(z, sign_width=0.3)[1]
    assert gradient @ way == pytest.approx((high - low) / 2e-6, rel=1e-4)


def test_proven_torque_holds_every_model(heavy):
    problem, scenarios = heavy
    shapes = Scenario(other_speeds(problem, SPEEDS[2]), scenarios[1].parameters)
    robust = RobustProblem.of(problem, "expected", [*scenarios, shapes])
    z = robust.random_start(np.random.default_rng(4))
    proven = robust.torque_range(z)
    assert proven is not None
    every = [s.model.torque(s.parameters, robust.trajectory.motion(z, T)) for s in robust.scenarios]
    low, high = np.min(every, axis=(0, 1)), np.max(every, axis=(0, 1))
    assert (proven[:, 0] <= low).all()
    assert (proven[:, 1] >= high).all()
    assert proven[:, 1] == pytest.approx(high, rel=0.05)
    limit = problem.limits.torque[:, 1]
    told = robust.torque_shares(z, len(T))
    for own, torque in zip(told[1:], every, strict=True):
        assert own == pytest.approx(np.abs(torque / limit).max(axis=0), rel=1e-9)


def test_values_of_linear_parameters_leave_the_criterion_alone(heavy):
    problem, scenarios = heavy
    robust = RobustProblem.of(problem, "worst", scenarios)
    assert not robust.has_shapes
    z = robust.random_start(np.random.default_rng(4))
    assert robust.costs(z) == pytest.approx(np.full(2, problem.cost(z)))
    assert torque_of_drawn(robust, z, robust.certificate(z))[0].standing == "proven"


def test_what_cannot_be_bounded_is_looked_at(heavy):
    class Torsion(Stribeck):
        def entries(self, state):
            (column,) = super().entries(state)
            return [
                {j: x * power(1.0 + magnitude(state.q[j]), state.q[j]) for j, x in column.items()}
            ]

    problem, scenarios = heavy
    effects = (*problem.model.effects[:-1], Torsion(1, 1.0))
    odd = [
        Scenario(dataclasses.replace(problem.model, effects=effects), s.parameters)
        for s in scenarios
    ]
    robust = RobustProblem.of(problem, "worst", odd)
    z = robust.random_start(np.random.default_rng(4))
    (told,) = torque_of_drawn(robust, z, robust.certificate(z))
    assert told.standing == "checked"
    assert "exponent that varies" in told.evidence
    beyond = robust.trajectory.shrink(z, np.full(2, 3.0))
    (told,) = torque_of_drawn(robust, beyond, robust.certificate(beyond))
    assert told.standing == "not kept"


def test_nothing_in_doubt_that_counts_is_refused(heavy):
    problem, scenarios = heavy
    free = dataclasses.replace(problem, nominal=None)
    with pytest.raises(NoUsableResult, match="nothing in this design depends"):
        RobustProblem.of(free, "worst", scenarios)


def test_models_that_cannot_stand_are_refused(heavy):
    problem, scenarios = heavy
    own = scenarios[1].parameters.copy()
    own[10:20] *= 20.0
    with pytest.raises(NoUsableResult, match=r"needs up to .* times its effort limit"):
        RobustProblem.of(problem, "worst", [scenarios[0], Scenario(problem.model, own)])
