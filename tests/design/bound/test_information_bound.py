import dataclasses

import numpy as np
import pytest

from oed.design.bound.balance import Monomials
from oed.design.bound.information_bound import BoundSettings, InformationBound, information_bound
from oed.design.bound.states import ViableStates
from oed.design.criteria import log10_det
from oed.design.optimisers import slsqp
from oed.design.optimisers.result import Budget
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass
from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.effects import Viscous
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import JointLimits, load_robot

SCARA = load_robot("builtin:imi_scara")
MODEL = TorqueModel.standard(SCARA)
BASE = base_parameters(MODEL)
QUICK = BoundSettings(degree=2, first_atoms=1000, states_per_round=4000, proof_tolerance=0.02)


@pytest.fixture(scope="module")
def bound() -> InformationBound:
    return information_bound(MODEL, BASE, SCARA.limits, np.random.default_rng(0), settings=QUICK)


def fourier(horizon: float, harmonics: int) -> DesignProblem:
    c = FourierClass(horizon, SCARA.limits, harmonics)
    return DesignProblem(MODEL, BASE, c, SCARA.limits, c.instants(80), "J_d", native=False)


def test_no_periodic_motion_tells_more(bound: InformationBound) -> None:
    rng = np.random.default_rng(0)
    for horizon, harmonics in ((3.0, 1), (6.0, 3), (10.0, 5), (20.0, 8)):
        problem = fourier(horizon, harmonics)
        for _ in range(5):
            average = problem.continuous_information(problem.random_start(rng))
            assert log10_det(average) < bound.J_d(80)


def test_not_even_an_optimised_one(bound: InformationBound) -> None:
    problem = fourier(10.0, 5)
    result = slsqp.optimise(problem, Budget(evaluations=120), np.random.default_rng(0))
    J_d = log10_det(problem.continuous_information(result.z))
    assert J_d > 18.5
    assert 0.3 < bound.efficiency(J_d, 80) < 1.0


def test_the_bound_is_certified_and_close_to_its_own_measure(bound: InformationBound) -> None:
    assert bound.kind == "certified"
    assert bound.boxes > 0
    assert 0 <= bound.log10_det - bound.attained < 8 * np.log10(1.03)


def test_more_test_functions_tighten_it(bound: InformationBound) -> None:
    none = dataclasses.replace(QUICK, degree=0)
    loose = information_bound(MODEL, BASE, SCARA.limits, np.random.default_rng(0), settings=none)
    assert bound.log10_det < loose.log10_det - 0.2


def test_a_motion_that_does_not_return_is_charged_the_way_back(bound: InformationBound) -> None:
    # By hand: brake 3.87 rad/s at 5 rad/s^2, cross 3 rad from rest to rest, speed up again.
    speed = np.sqrt(2 * 5 * 1.5)
    assert bound.longest_return == pytest.approx(2 * speed / 5 + 2 * np.sqrt(3 / 5))
    longer = bound.J_d(80, horizon=10.0) - bound.J_d(80)
    assert longer == pytest.approx(8 * np.log10(1 + bound.longest_return / 10))


def test_instants_only_add(bound: InformationBound) -> None:
    assert bound.J_d(160) - bound.J_d(80) == pytest.approx(8 * np.log10(2))
    assert bound.efficiency(bound.J_d(80), 80) == pytest.approx(1.0)


def test_noise_of_the_torque_scales_it(bound: InformationBound) -> None:
    noisy = information_bound(
        MODEL,
        BASE,
        SCARA.limits,
        np.random.default_rng(0),
        covariance=np.array([4.0, 4.0]),
        settings=QUICK,
    )
    assert noisy.log10_det - bound.log10_det == pytest.approx(-8 * np.log10(4.0), abs=0.15)


def test_beyond_two_joints_it_is_an_estimate(bound: InformationBound) -> None:
    estimate = information_bound(
        MODEL, BASE, SCARA.limits, np.random.default_rng(0), settings=QUICK, certify=False
    )
    assert estimate.kind == "estimated"
    assert estimate.boxes == 0
    assert abs(estimate.log10_det - bound.log10_det) < 0.2


def test_viscous_friction_alone_cannot_beat_full_speed() -> None:
    # One column, v of joint 1: without test functions the best measure sits at full speed, and
    # Lambda is that speed squared.
    model = TorqueModel(SCARA, (Viscous(0),))
    limits = dataclasses.replace(SCARA.limits, velocity=np.array([[-2.0, 2.0], [-1.0, 1.0]]))
    one = BaseParameters(
        columns=np.array([0]),
        regrouping=np.eye(1),
        singular_values=np.ones(1),
        names=("Fv_1",),
        expressions=("Fv_1",),
        units=("N m s/rad",),
        joints=(0,),
    )
    settings = dataclasses.replace(QUICK, degree=0)
    result = information_bound(model, one, limits, np.random.default_rng(0), settings=settings)
    assert result.log10_det == pytest.approx(np.log10(4.0), abs=0.01)


def test_states_cover_every_state_of_a_periodic_motion() -> None:
    states = ViableStates(SCARA.limits)
    problem = fourier(10.0, 5)
    rng = np.random.default_rng(1)
    down = up = SCARA.limits.acceleration[0, 1]
    for _ in range(20):
        motion = problem.trajectory.motion(problem.random_start(rng), np.linspace(0, 10, 500))
        assert (np.abs(motion.dq) <= states.fastest + 1e-9).all()
        assert (motion.dq**2 <= 2 * down * (1.5 - motion.q) + 1e-6).all()
        assert (motion.dq**2 <= 2 * up * (motion.q + 1.5) + 1e-6).all()


def test_coordinates_stay_in_the_limits() -> None:
    states = ViableStates(SCARA.limits)
    x, ddq = states.sample(2000, np.random.default_rng(0))
    motion = states.motion(x, ddq)
    assert (np.abs(motion.q) <= 1.5 + 1e-12).all()
    assert (np.abs(motion.ddq) == 5.0).all()


def test_rates_are_time_derivatives_and_vanish_on_average() -> None:
    functions = Monomials.up_to(4, np.zeros(2), np.array([1.5, 1.5, 3.0, 3.0]))
    problem = fourier(10.0, 3)
    z = problem.random_start(np.random.default_rng(2))
    t = np.arange(4000) * (10.0 / 4000)
    rates = functions.rates(problem.trajectory.motion(z, t))
    assert np.abs(rates.mean(axis=0)).max() < 1e-9 * np.abs(rates).max()
    step = 1e-5
    moved = [phi(functions, problem.trajectory.motion(z, t[:50] + s)) for s in (step, -step)]
    difference = (moved[0] - moved[1]) / (2 * step)
    np.testing.assert_allclose(rates[:50], difference, atol=1e-6)


def phi(functions: Monomials, motion: Motion) -> np.ndarray:
    values = np.concatenate([motion.q, motion.dq], axis=1) / functions.scale
    return np.prod(values[:, None, :] ** functions.exponents, axis=2)


def test_needs_limits_that_bound_the_states() -> None:
    free = JointLimits.symmetric(position=(1.0, 1.0), velocity=(1.0, 1.0))
    with pytest.raises(ValueError, match="acceleration"):
        ViableStates(free)


def quadratics(x: np.ndarray) -> np.ndarray:
    return np.stack([np.ones_like(x), x, x**2], axis=1)


@pytest.mark.parametrize("middle", [1 / 3, 0.5, 0.6, 0.8])
def test_a_measure_bounds_the_textbook_optimum(middle: float) -> None:
    # Regression on 1, x, x^2 over [-1, 1]: D-optimal is a third at each of -1, 0 and 1, det 4/27
    # (Fedorov 1972), and by the equivalence theorem its dual has its maximum 3 there.
    ends = (1 - middle) / 2
    F = quadratics(np.array([-1.0, 0.0, 1.0]))
    information = F.T @ (np.array([ends, middle, ends])[:, None] * F)
    x = quadratics(np.linspace(-1, 1, 2001))
    highest = np.einsum("ij,jk,ik->i", x, np.linalg.inv(information), x).max()
    found = InformationBound.of_measure(
        information, highest, kind="estimated", functions=3, boxes=0, longest_return=0.0
    )
    best = np.log10(4 / 27)
    if middle == 1 / 3:
        assert found.log10_det == pytest.approx(best)
        assert found.excess == pytest.approx(0.0, abs=1e-12)
    else:
        assert found.attained < best < found.log10_det
        assert found.excess > 0
    # N instants have N times the mean information, and det of b = 3 parameters N^3 times it.
    assert found.J_d(80) == pytest.approx(found.log10_det + np.log10(80.0**3))
