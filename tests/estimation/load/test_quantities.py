import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from oed.estimation.load.consistent_body import ball, consistent_body, radius_of
from oed.estimation.load.quantities import (
    LinearEstimate,
    _ratio_interval,
    _slopes,
    _values,
    central_inertia,
    quantities,
)
from oed.robot.inertia import parameters_from_pseudo_inertia, pseudo_inertia, transform_parameters

BODY = transform_parameters(
    parameters_from_pseudo_inertia(np.diag([0.02, 0.01, 0.03, 2.0])),
    Rotation.from_rotvec([0.3, -0.5, 0.2]).as_matrix(),
    np.array([0.02, -0.03, 0.06]),
)
NOTHING_OPEN = np.zeros((10, 0))


def known(parameters, covariance, freedom=1e6):
    return LinearEstimate(parameters, covariance, np.full(10, freedom), NOTHING_OPEN)


def test_slopes_are_those_of_the_values():
    for k in range(10):
        step = 1e-6 * np.eye(10)[k]
        by_difference = (_values(BODY + step) - _values(BODY - step)) / 2e-6
        assert _slopes(BODY)[:, k] == pytest.approx(by_difference, abs=1e-6)


def test_a_centre_of_mass_is_held_however_badly_the_mass_is_known():
    rng = np.random.default_rng(0)
    std = np.array([0.3, *(0.02,) * 3, *(1e-3,) * 6])
    hits = 0
    for _ in range(2000):
        drawn = BODY + std * rng.standard_normal(10)
        interval = _ratio_interval(known(drawn, np.diag(std**2)), 3, 1.96)
        assert interval is not None
        low, high = interval
        hits += low <= BODY[3] / BODY[0] <= high
    assert 0.94 < hits / 2000 <= 0.97


def test_a_ball_has_its_mass_radius_and_inertia():
    body = ball(4.0, np.array([0.0, 0.1, 0.0]))
    assert body[:4] == pytest.approx([4.0, 0.0, 0.4, 0.0])
    assert central_inertia(body) == pytest.approx(0.4 * 4.0 * radius_of(4.0) ** 2 * np.eye(3))
    assert 4 / 3 * np.pi * radius_of(4.0) ** 3 * 1000 == pytest.approx(4.0)


def test_a_body_that_can_exist_stays_where_it_is():
    covariance = np.diag((1e-3 * np.array([1.0, *(0.1,) * 3, *(0.02,) * 6])) ** 2)
    found, solution = consistent_body(BODY, covariance, np.eye(10), ball(2.0, BODY[1:4] / 2))
    assert solution.is_accurate
    assert np.all(np.abs(found - BODY) < 0.1 * np.sqrt(np.diag(covariance)))


def test_a_body_that_cannot_exist_becomes_the_nearest_one():
    cp = pytest.importorskip("cvxpy")
    impossible = BODY.copy()
    impossible[9] += 0.08  # more than Ixx and Iyy together
    std = 0.01 * np.array([1.0, *(0.1,) * 3, *(1.0,) * 6])
    found, _ = consistent_body(impossible, np.diag(std**2), np.eye(10), ball(2.0, BODY[1:4] / 2))
    x = cp.Variable(10)
    pseudo = sum(x[k] * pseudo_inertia(np.eye(10)[k]) for k in range(10))
    problem = cp.Problem(cp.Minimize(cp.sum_squares((x - impossible) / std)), [pseudo >> 0])
    problem.solve(solver="CLARABEL")
    assert np.linalg.eigvalsh(pseudo_inertia(impossible))[0] < 0
    assert np.linalg.eigvalsh(pseudo_inertia(found))[0] > 0
    # The pull to the ball, and the margin, cost a few hundredths of a standard deviation.
    assert np.all(np.abs(found - x.value) < 0.15 * std)


def test_no_interval_is_claimed_for_what_is_open():
    open_z = LinearEstimate(BODY, 1e-6 * np.eye(10), np.full(10, 50.0), np.eye(10)[:, 3:4])
    told = {q.name: q.interval for q in quantities(open_z, BODY, np.ones(10))}
    assert told["z"] is None
    assert told["Ixx"] is None  # about a centre whose z is open
    assert told["mass"] is not None
    assert told["Izz"] is not None
