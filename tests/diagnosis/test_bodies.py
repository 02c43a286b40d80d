"""What a body cannot be is not called a load."""

import numpy as np
import pytest

from oed.diagnosis.terms.bodies import LOST, lost_by_bodies
from oed.robot.inertia import parameters_from_pseudo_inertia

ALL = np.eye(10)
PLANAR = ALL[[0, 1, 2, 9]]  # mass, first moments, inertia about the axis


def body(rng, points=6):
    """The parameters of some point masses."""
    places = np.column_stack([rng.normal(size=(points, 3)), np.ones(points)])
    return parameters_from_pseudo_inertia((places * rng.uniform(0.1, 1.0, (points, 1))).T @ places)


@pytest.mark.parametrize("shown", [PLANAR, ALL])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_bodies_lose_nothing_whether_taken_up_or_put_down(shown, sign):
    rng = np.random.default_rng(4)
    for _ in range(5):
        root = rng.normal(size=(len(shown), len(shown)))
        values = sign * shown @ body(rng)
        assert lost_by_bodies(shown, values, root @ root.T) < 1e-6


def test_an_inertia_without_the_mass_for_it_loses_what_speaks_for_the_mass():
    # Nearest body: no mass at all, so neither first moment nor inertia of the wrong sign.
    deviations = np.array([0.01, 0.001, 0.001, 0.002])
    values = np.array([-0.05, 0.0, 0.0, 0.006])
    taken_up = (values[0] / deviations[0]) ** 2
    put_down = (values[3] / deviations[3]) ** 2
    lost = lost_by_bodies(PLANAR, values, np.diag(deviations**2))
    assert lost == pytest.approx(min(taken_up, put_down) / (taken_up + put_down), rel=1e-3)
    assert lost > LOST


def test_noise_on_a_load_that_is_clearly_there_loses_little():
    rng = np.random.default_rng(5)
    for _ in range(10):
        truth = body(rng)
        deviations = 0.05 * np.abs(truth).max() * np.ones(10)
        values = truth + deviations * rng.normal(size=10)
        assert lost_by_bodies(ALL, values, np.diag(deviations**2)) < LOST


def test_noise_alone_seldom_looks_like_a_body():
    rng = np.random.default_rng(6)
    lost = [lost_by_bodies(ALL, rng.normal(size=10), np.eye(10)) for _ in range(40)]
    assert np.mean(np.array(lost) > LOST) > 0.9


def test_what_the_data_do_not_see_of_a_load_speaks_for_no_other_body():
    rng = np.random.default_rng(7)
    for seen in (4, 7, 9):
        columns = rng.normal(size=(seen, 10))
        covariance = np.linalg.pinv(columns.T @ columns, hermitian=True)
        values = np.linalg.pinv(columns) @ columns @ body(rng)
        assert lost_by_bodies(ALL, values, covariance) < 1e-6
