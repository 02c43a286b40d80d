"""Every class: exact derivatives, sensitivities and bounds."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from oed.design.extrema import proven_range
from oed.design.trajectories import FourierClass, HarmonicClass, LinearClass, SplineClass
from tests.design.problems import HORIZON, classes, lopsided, scara

LIMITS = lopsided()
CLASSES = classes(LIMITS)
T = np.linspace(0.2, 9.7, 37)


@pytest.fixture(params=CLASSES)
def case(request):
    trajectory = CLASSES[request.param]
    return trajectory, trajectory.draw(np.random.default_rng(3))


@pytest.mark.parametrize("order", [1, 2, 3])
def test_derivatives_are_those_of_position(case, order) -> None:
    trajectory, z = case
    h = 1e-5
    below, above = (trajectory.derivative(z, T + s * h, order - 1) for s in (-1, 1))
    exact = trajectory.derivative(z, T, order)
    np.testing.assert_allclose((above - below) / (2 * h), exact, atol=1e-6 * np.abs(exact).max())


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_sensitivities_are_those_of_the_motion(case, order) -> None:
    trajectory, z = case
    exact = trajectory.sensitivity(z, T, order)
    for joint, own in enumerate(trajectory.variables):
        for place, variable in enumerate(own):
            step = np.zeros(trajectory.size)
            step[variable] = 1e-6
            difference = trajectory.derivative(z + step, T, order)
            difference = (difference - trajectory.derivative(z - step, T, order)) / 2e-6
            np.testing.assert_allclose(difference[:, joint], exact[:, joint, place], atol=1e-5)
            others = np.delete(difference, joint, axis=1)
            assert np.abs(others).max() < 1e-9


def test_pull_back_is_the_product_with_the_sensitivities(case) -> None:
    trajectory, z = case
    rng = np.random.default_rng(0)
    adjoints = tuple(rng.standard_normal((len(T), 2)) for _ in range(3))
    step = 1e-6 * rng.standard_normal(trajectory.size)

    def weighted(z: np.ndarray) -> float:
        return sum((trajectory.derivative(z, T, k) * a).sum() for k, a in enumerate(adjoints))

    change = weighted(z + step) - weighted(z - step)
    assert change == pytest.approx(2 * trajectory.pull_back(z, T, adjoints) @ step, rel=1e-5)


def test_the_bound_on_a_derivative_is_never_exceeded(case) -> None:
    trajectory, z = case
    t = np.linspace(0, HORIZON, 20_001)
    for order in range(6):
        centre = trajectory.centre(z) if order == 0 else 0.0
        largest = np.abs(trajectory.derivative(z, t, order) - centre).max(axis=0)
        assert (largest <= trajectory.derivative_bound(z, order) * (1 + 1e-12)).all()


def test_the_bound_counts_every_product_of_ramp_and_sine() -> None:
    # The fourth derivative, by which an acceleration between samples is bounded. At this frequency
    # products of lower derivatives are most of it: counted once each, they are passed by 8 %.
    ramp, omega = 1.0, 6.8
    trajectory = HarmonicClass(HORIZON, np.zeros(1), 1, np.ones(1), np.full(1, 10.0), ramp)
    z = np.array([1.0, omega])
    largest = np.abs(trajectory.derivative(z, np.linspace(0, HORIZON, 20_001), 4)).max()
    assert (
        0.5 * trajectory.derivative_bound(z, 4)[0] < largest <= trajectory.derivative_bound(z, 4)[0]
    )


def test_shrinking_scales_the_distance_from_the_centre(case) -> None:
    trajectory, z = case
    smaller = trajectory.shrink(z, np.array([0.5, 0.1]))
    centre = trajectory.centre(z)
    before, after = (trajectory.derivative(x, T, 0) - centre for x in (z, smaller))
    np.testing.assert_allclose(after, before * [0.5, 0.1], atol=1e-12)


@pytest.mark.parametrize("name", ["ramped", "fourier_at_rest", "spline_at_rest"])
def test_starts_and_ends_at_rest(name) -> None:
    trajectory = CLASSES[name]
    z = trajectory.draw(np.random.default_rng(1))
    ends = np.array([0.0, HORIZON])
    for order in (1, 2):
        assert np.abs(trajectory.derivative(z, ends, order)).max() < 1e-10


@pytest.mark.parametrize("name", ["collocation", "spline_at_rest"])
def test_splines_return_smoothly(name) -> None:
    trajectory = CLASSES[name]
    z = trajectory.draw(np.random.default_rng(2))
    for order in range(trajectory.degree):
        start, end = trajectory.derivative(z, np.array([0.0, HORIZON]), order)
        np.testing.assert_allclose(start, end, atol=1e-10)


def test_acceleration_of_collocation_is_piecewise_linear_and_integrates_to_position() -> None:
    trajectory = CLASSES["collocation"]
    z = trajectory.draw(np.random.default_rng(2))
    knots = np.array(trajectory.breakpoints)
    at_knots = trajectory.derivative(z, knots, 2)
    t = np.linspace(0.0, HORIZON, 200_001)
    ddq = np.stack([np.interp(t, knots, at_knots[:, j]) for j in range(2)], axis=1)
    start = trajectory.motion(z, np.zeros(1))
    dq = start.dq + cumulative_trapezoid(ddq, t, axis=0, initial=0)
    q = start.q + cumulative_trapezoid(dq, t, axis=0, initial=0)
    np.testing.assert_allclose(trajectory.derivative(z, t, 0), q, atol=1e-7)


@pytest.mark.parametrize("name", ["fourier", "collocation", "spline_at_rest"])
def test_at_half_the_speed_the_same_way_takes_twice_as_long(name) -> None:
    trajectory = CLASSES[name]
    z = trajectory.draw(np.random.default_rng(2))
    slow = trajectory.slower(0.5)
    for order in range(3):
        np.testing.assert_allclose(
            slow.derivative(z, 2 * T, order),
            trajectory.derivative(z, T, order) / 2**order,
            atol=1e-9,
        )


@pytest.mark.parametrize("name", ["fourier", "collocation", "spline_at_rest"])
def test_a_swing_is_near_the_sine(name) -> None:
    trajectory = CLASSES[name]
    middle, amplitude = np.array([0.5, -1.0]), np.array([0.7, 0.3])
    rate = 2 * np.pi / HORIZON * np.array([1.0, 2.0])
    z = trajectory.swing(middle, amplitude, rate)
    assert z is not None
    t = np.linspace(2.0, 8.0, 100)
    sine = middle + amplitude * np.sin(t[:, None] * rate)
    allowed = 0.3 if trajectory.at_rest else 0.01
    assert (np.abs(trajectory.derivative(z, t, 0) - sine) < allowed * amplitude).all()


@pytest.mark.parametrize("name", ["collocation", "spline_at_rest"])
def test_the_box_of_splines_holds_admissible_motions(name) -> None:
    trajectory = CLASSES[name]
    lower, upper = (side.reshape(2, -1) for side in trajectory.bounds.T)
    knots = np.array(trajectory.breakpoints[:-1])
    closest = []
    for mode in range(1, trajectory.own):
        # Acceleration that switches with the mode has most of it; then as large as limits allow.
        acceleration = trajectory.basis(knots, 2)
        own, *_ = np.linalg.lstsq(acceleration[:, 1:], np.sign(acceleration[:, mode]), rcond=None)
        z = np.tile(np.append(0.0, own), 2)
        swing = [np.abs(proven_range(trajectory, z, order)).max(axis=1) for order in range(3)]
        most = [np.ptp(LIMITS.position, axis=1) / 2] + [
            np.abs(limit).max(axis=1) for limit in (LIMITS.velocity, LIMITS.acceleration)
        ]
        z = trajectory.shrink(z, np.min([m / s for m, s in zip(most, swing, strict=True)], axis=0))
        inside = np.abs(z.reshape(2, -1)[:, mode]) / upper[:, mode]
        assert (inside <= 1.0).all()
        assert (lower[:, mode] == -upper[:, mode]).all()
        closest.append(inside.max())
    assert max(closest) > 0.5


def test_the_general_box_is_that_of_the_series() -> None:
    # For a series 4 / pi is the norm of a harmonic's coefficient: the general route finds it.
    series = CLASSES["fourier"]
    general = LinearClass.bounds.func(series)  # type: ignore[attr-defined]  # a cached property
    np.testing.assert_allclose(general, series.bounds, rtol=2e-3)


@pytest.mark.parametrize("wrong", [{"degree": 2}, {"degree": 8}, {"segments": 6}])
def test_refuses_splines_that_are_none(wrong) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        SplineClass(HORIZON, LIMITS, **wrong)


def test_harmonic_motion_is_the_papers_sum_of_sines() -> None:
    robot, *_ = scara()
    trajectory = HarmonicClass.conservative(robot.limits, HORIZON, terms=2)
    z = np.array([0.1, 0.2, 0.3, -0.4, 0.5, 1.0, 1.5, 1.8])  # a_11 a_12 a_21 a_22, then omega
    expected = np.stack(
        [
            0.1 * np.sin(0.5 * T) + 0.2 * np.sin(1.0 * T),
            0.3 * np.sin(1.5 * T) - 0.4 * np.sin(1.8 * T),
        ],
        axis=1,
    )
    np.testing.assert_allclose(trajectory.derivative(z, T, 0), expected, atol=1e-14)


def test_the_conservative_box_is_the_papers() -> None:
    robot, *_ = scara()
    trajectory = HarmonicClass.conservative(robot.limits, HORIZON)
    assert trajectory.bounds[0, 1] == pytest.approx(0.5)  # q_max / W (12c)
    assert trajectory.bounds[-1, 1] == pytest.approx(1.825, abs=1e-3)  # (12d)


def test_refuses_a_class_without_finite_position_limits() -> None:
    robot, *_ = scara()
    free = robot.limits.with_(position=np.tile([-np.inf, np.inf], (2, 1)))
    with pytest.raises(ValueError, match="finite position limits"):
        FourierClass(HORIZON, free)
    with pytest.raises(ValueError, match="finite position limits"):
        HarmonicClass.exact(free, HORIZON)
