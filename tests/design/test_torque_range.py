"""Proven torque of models with effects, against dense samples; and one clear refusal."""

import numpy as np
import pytest

from oed.design.default_problem import ProblemSettings, default_problem
from oed.design.interval import Interval
from oed.design.limits import fill
from oed.design.torque_range import (
    TorqueNotBounded,
    check_torque_bounded,
    proven_torque_range,
)
from oed.design.trajectories import FourierClass
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.effect import Effect
from oed.dynamics.effects.friction import Coulomb
from oed.dynamics.torque_model import TorqueModel
from tests.dynamics.effects.arms import context_of, vertical_arm

BOUNDED = [
    "stribeck",
    "nonlinear_viscous",
    "asymmetric_viscous",
    "load_dependent_friction",
    "position_dependent_friction",
    "torque_ripple",
    "joint_spring",
    "gravity_direction",
    "rotor_inertia",
    "torque_gain",
    "torque_saturation",
]
# They remember the motion before, or the time since a recording began.
NOT_BOUNDED = ["presliding_hysteresis", "backlash", "thermal_drift", "payload_change"]


def effect(name: str) -> Effect:
    context, entry = context_of(vertical_arm()), CATALOGUE[name]
    target = entry.targets(context)[0]
    values = tuple(shape.default for shape in entry.shapes_for(context, target))
    built = entry.build(context, target, values)
    assert isinstance(built, Effect)
    return built


@pytest.mark.parametrize("name", BOUNDED)
def test_no_sample_leaves_the_proven_range(name: str) -> None:
    robot = vertical_arm()
    model = TorqueModel(robot, (effect(name),))
    sizes = np.ones(len(model.parameters))
    trajectory = FourierClass(10.0, robot.limits)
    z = fill(trajectory, trajectory.draw(np.random.default_rng(0)), robot.limits)
    proven = proven_torque_range(model, sizes[None], trajectory, z)
    seen = model.torque(sizes, trajectory.motion(z, np.linspace(0.0, 10.0, 5001)))
    assert (proven[:, 0] <= seen).all()
    assert (proven[:, 1] >= seen).all()


def test_a_sign_that_turns_slowly_is_bounded_by_its_friction() -> None:
    robot = vertical_arm()
    model = TorqueModel(robot, tuple(Coulomb(j, 1e-3, gradual=True) for j in range(robot.n)))
    trajectory = FourierClass(10.0, robot.limits)
    z = fill(trajectory, trajectory.draw(np.random.default_rng(0)), robot.limits)
    proven = proven_torque_range(model, np.array([[2.0, 3.0], [1.0, 4.0]]), trajectory, z)
    assert (proven[:, 1] >= [2.0 - 1e-6, 4.0 - 1e-6]).all()
    assert (proven[:, 0] <= [-2.0 + 1e-6, -4.0 + 1e-6]).all()


@pytest.mark.parametrize("name", NOT_BOUNDED)
def test_an_effect_that_cannot_be_bounded_is_named(name: str) -> None:
    model = TorqueModel(vertical_arm(), (effect(name),))
    with pytest.raises(TorqueNotBounded, match=name) as caught:
        check_torque_bounded(model, np.ones((1, len(model.parameters))))
    assert caught.value.effect == name


def test_an_effect_that_the_nominal_model_leaves_out_does_no_harm() -> None:
    robot = vertical_arm()
    limits = robot.limits.with_(torque=np.array([[-400.0, 400.0], [-100.0, 100.0]]))
    model = TorqueModel.standard(robot.with_limits(limits)).with_effects(effect("backlash"))
    nominal = np.zeros(len(model.parameters))
    nominal[: len(robot.parameters)] = robot.parameters
    check_torque_bounded(model, nominal[None])


def test_the_default_problem_limits_torque_beside_an_effect() -> None:
    robot = vertical_arm()
    limits = robot.limits.with_(torque=np.array([[-400.0, 400.0], [-100.0, 100.0]]))
    model = TorqueModel.standard(robot.with_limits(limits)).with_effects(effect("rotor_inertia"))
    problem = default_problem(model, ProblemSettings(instants=40)).problem
    certificate = problem.certificate(problem.random_start(np.random.default_rng(0)))
    assert certificate.torque is not None
    assert certificate.is_feasible


@pytest.mark.parametrize(
    ("exponent", "lower", "upper"),
    [(2.0, 0.0, 9.0), (3.0, -27.0, 8.0), (0.5, 0.0, np.sqrt(2.0))],
)
def test_power_of_an_interval_across_zero(exponent: float, lower: float, upper: float) -> None:
    power = np.power(Interval(np.array([-3.0]), np.array([2.0])), exponent)
    assert power.lower[0] == pytest.approx(lower)
    assert power.upper[0] == pytest.approx(upper)


def test_an_interval_is_never_taken_for_a_number() -> None:
    interval = Interval(np.zeros(2), np.ones(2))
    with pytest.raises(NotImplementedError):
        _ = interval > 0.5
    with pytest.raises(NotImplementedError):
        np.asarray(interval)
    with pytest.raises(NotImplementedError):
        _ = 1.0 / interval
