"""Proof and repair: no dense check ever exceeds a certificate."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from oed.design.extrema import FIRST_INTERVALS, proven_range, quick_range
from oed.design.limits import (
    KINEMATIC,
    Certificate,
    certify,
    check_limits,
    fill,
    repair,
    violation_of,
)
from oed.design.torque_range import proven_torque_range
from oed.design.trajectories import FourierClass, HarmonicClass
from oed.robot import JointLimits
from tests.design.problems import HORIZON, classes, lopsided, scara

DENSE = np.linspace(0.0, HORIZON, 100_000)
LIMITS = lopsided()
CLASSES = classes(LIMITS)


@pytest.mark.parametrize("name", CLASSES)
@pytest.mark.parametrize("seed", range(3))
def test_a_dense_check_never_exceeds_the_certificate(name, seed) -> None:
    trajectory = CLASSES[name]
    z = fill(trajectory, trajectory.draw(np.random.default_rng(seed)), LIMITS)
    certificate = certify(trajectory, z, LIMITS)
    t = np.union1d(DENSE, trajectory.breakpoints)  # a kink is an extremum of its own
    for order, kind in enumerate(KINEMATIC):
        values = trajectory.derivative(z, t, order)
        proven = getattr(certificate, kind)
        assert (values >= proven[:, 0]).all()
        assert (values <= proven[:, 1]).all()
        # and the proof is tight: no more than a millionth of the motion's scale wasted
        scale = trajectory.derivative_bound(z, order)
        assert (proven[:, 1] - values.max(axis=0) < 1e-5 * scale).all()
        assert (values.min(axis=0) - proven[:, 0] < 1e-5 * scale).all()


@pytest.mark.parametrize("name", CLASSES)
@pytest.mark.parametrize("seed", range(3))
def test_repair_returns_a_proven_motion(name, seed) -> None:
    trajectory = CLASSES[name]
    wild = np.random.default_rng(seed).uniform(*(3 * trajectory.bounds.T))
    for is_quick in (False, True):
        z = repair(trajectory, wild, LIMITS, is_quick=is_quick)
        assert certify(trajectory, z, LIMITS).violation <= 0


def test_sees_a_beat_that_falls_between_samples() -> None:
    # Two fast sines that cancel at every one of 80 samples and add up in between.
    spacing = HORIZON / 80
    omega = np.array([[np.pi / spacing, np.pi / spacing]])
    trajectory = HarmonicClass(HORIZON, np.zeros(1), 2, np.ones(1), np.full(1, 2 * np.pi / spacing))
    z = np.concatenate([[0.5, 0.5], omega[0]])
    seen = np.abs(trajectory.derivative(z, trajectory.instants(80), 0)).max()
    assert seen < 1e-10
    lower, upper = proven_range(trajectory, z, 0)[0]
    assert upper == pytest.approx(1.0, abs=1e-6)
    assert lower == pytest.approx(-1.0, abs=1e-6)


@pytest.mark.parametrize("multiple", [1, 2, 3])
def test_sees_a_wave_that_has_its_troughs_at_every_first_sample(multiple: int) -> None:
    # Slopes vanish there too: only the curvature tells that there are crests in between.
    count = FIRST_INTERVALS * multiple
    trajectory = FourierClass(HORIZON, JointLimits.symmetric([2.0], [1e9], [1e9]), count)
    z = np.zeros(trajectory.size)
    z[-1] = -1.0 if multiple % 2 == 0 else 1.0
    lower, upper = proven_range(trajectory, z, 0)[0]
    assert lower == pytest.approx(-1.0, abs=1e-6)
    assert upper == pytest.approx(1.0, abs=1e-6)


def test_a_cubic_splines_extrema_are_those_of_its_polynomials() -> None:
    trajectory = CLASSES["collocation"]
    z = trajectory.draw(np.random.default_rng(4))
    knots = np.array(trajectory.breakpoints)
    values, slopes = (trajectory.derivative(z, knots, order) for order in (0, 1))
    for joint in range(2):
        cubic = CubicHermiteSpline(knots, values[:, joint], slopes[:, joint])
        for order in range(3):
            part = cubic.derivative(order)
            turning = cubic.derivative(order + 1).roots(extrapolate=False)
            seen = part(np.concatenate([knots, turning[np.isfinite(turning)]]))
            proven = proven_range(trajectory, z, order)[joint]
            scale = 1e-6 * np.abs(seen).max()
            assert proven[0] <= seen.min() <= proven[0] + scale
            assert proven[1] - scale <= seen.max() <= proven[1]


@pytest.mark.parametrize("name", ["ramped", "collocation", "spline_at_rest"])
def test_the_quick_range_holds_the_proven_one(name) -> None:
    trajectory = CLASSES[name]
    z = trajectory.draw(np.random.default_rng(5))
    for order in range(4):
        quick, proven = quick_range(trajectory, z, order), proven_range(trajectory, z, order)
        slack = 1e-6 * trajectory.derivative_bound(z, order)
        assert (quick[:, 0] <= proven[:, 0] + slack).all()
        assert (quick[:, 1] >= proven[:, 1] - slack).all()


@pytest.mark.parametrize("name", ["fourier", "collocation"])
def test_torque_is_proven_too(name) -> None:
    robot, model, _ = scara()
    trajectory = classes(robot.limits)[name]
    z = fill(trajectory, trajectory.draw(np.random.default_rng(0)), robot.limits)
    friction = [2.61, 7.343, 1.46, 0.787]  # Calafiore 2001, section 5
    parameters = np.concatenate([robot.parameters, friction])
    proven = proven_torque_range(model, parameters[None], trajectory, z)
    torque = model.torque(parameters, trajectory.motion(z, DENSE))
    seen = np.stack([torque.min(axis=0), torque.max(axis=0)], axis=1)
    assert (proven[:, 0] <= seen[:, 0]).all()
    assert (proven[:, 1] >= seen[:, 1]).all()
    assert np.abs(proven - seen).max() < 0.02 * np.abs(seen).max()


@pytest.mark.parametrize(
    ("reach", "told"),
    [
        (0.5, "position of joint 1, proven 5.00e-01 of it to spare"),
        (1.0, "position of joint 1, proven 0.00e+00 of it to spare"),
        (1.25, "position of joint 1, exceeded by 2.50e-01 of it"),
    ],
)
def test_the_nearest_limit_is_said_without_a_sign(reach: float, told: str) -> None:
    bounds = np.array([[-reach, reach]])
    limit = np.array([[-1.0, 1.0]])
    violation = float(violation_of(bounds, limit)[0])
    none = np.zeros((0, 2))
    held = Certificate(bounds, bounds, bounds, bounds, None, violation, "position of joint 1", none)
    assert held.nearest == told


def test_refuses_limits_that_forbid_motion_in_one_direction() -> None:
    with pytest.raises(ValueError, match="velocity limit of joint 1"):
        check_limits(LIMITS.with_(velocity=np.array([[0.1, 1.0], [-1.0, 1.0]])))
