import numpy as np
import pytest

from oed.estimation.feasible.coordinates import Coordinates
from oed.estimation.feasible.regularisation import Regularisation
from tests.estimation.feasible.cases import random_body


@pytest.fixture
def coordinates():
    rng = np.random.default_rng(1)
    return Coordinates.relative_to(
        np.concatenate([random_body(rng), random_body(rng)]), np.array([0.5])
    )


@pytest.mark.parametrize("kind", ["entropic", "quadratic"])
def test_nothing_is_nearer_than_the_reference(coordinates, kind):
    pull = Regularisation(1.0, kind)
    rng = np.random.default_rng(2)
    assert pull.value(coordinates, coordinates.start) == pytest.approx(0.0, abs=1e-12)
    for _ in range(20):
        x = coordinates.start + 0.1 * rng.normal(size=21)
        assert pull.value(coordinates, x) > 0


@pytest.mark.parametrize("kind", ["entropic", "quadratic"])
def test_derivatives_agree_with_differences(coordinates, kind):
    pull = Regularisation(1.0, kind)
    rng = np.random.default_rng(3)
    x = coordinates.start + 0.1 * rng.normal(size=21)
    for direction in rng.normal(size=(5, 21)):
        step = 1e-6 * direction
        slope = (pull.value(coordinates, x + step) - pull.value(coordinates, x - step)) / 2e-6
        assert pull.gradient(coordinates, x) @ direction == pytest.approx(slope, rel=1e-6, abs=1e-8)
        turn = (pull.gradient(coordinates, x + step) - pull.gradient(coordinates, x - step)) / 2e-6
        assert np.allclose(pull.hessian(coordinates, x) @ direction, turn, rtol=1e-5, atol=1e-6)


def test_entropic_is_infinite_where_a_link_is_inconsistent(coordinates):
    x = coordinates.start
    x[:10] *= -1
    assert Regularisation(1.0).value(coordinates, x) == np.inf


def test_entropic_is_the_relative_entropy_of_scaled_bodies(coordinates):
    # J = 2 J_0 in one link: tr(2 I) - log det(2 I) - 4.
    x = coordinates.start
    x[:10] *= 2
    assert Regularisation(1.0).value(coordinates, x) == pytest.approx(8 - 4 * np.log(2) - 4)


@pytest.mark.parametrize("weight", [0.0, 1e-300, 1e-13, 1e7, np.nan])
def test_refuses_a_pull_that_no_digit_is_left_for(weight):
    with pytest.raises(ValueError, match="must be from 1e-12 to 1e\\+06"):
        Regularisation(weight)
