import numpy as np
import pytest
from scipy import stats

from oed.estimation.identify import identify
from oed.estimation.prior import Prior
from oed.estimation.triangular import NotIdentifiable
from tests.estimation.planar_arm import NAMES, TRUTH, UNITS, planar_regressor, torque, white_noise


@pytest.fixture
def data():
    rng = np.random.default_rng(6)
    W = planar_regressor(rng, 400)
    return W, torque(W, 0.1 * white_noise(rng, 400)).reshape(400, 2)


def test_recovers_the_truth_within_its_intervals(data):
    W, tau = data
    found = identify(W, tau, NAMES, UNITS, covariance="white")
    interval = found.interval(0.999)
    assert np.all((interval[:, 0] < TRUTH) & (interval[:, 1] > TRUTH))
    assert np.allclose(found.residual, tau - (W @ found.parameters).reshape(400, 2))
    assert found.degrees_of_freedom == 792
    assert found.status == "determined"
    assert found.unidentifiable == ()


def test_intervals_are_those_of_student(data):
    W, tau = data
    found = identify(W, tau, NAMES, UNITS, covariance="white")
    reach = stats.t.ppf(0.95, 792) * found.std
    # Away from zero: the other end knows that what is small is not quoted.
    far = np.where(found.parameters > 0, *found.interval(0.9).T[::-1])
    assert np.allclose(np.abs(far - found.parameters), reach)


def test_a_dependent_column_gets_a_name_and_no_number(data):
    W, tau = data
    found = identify(np.column_stack([W, W[:, 4]]), tau, (*NAMES, "twin"), (*UNITS, "N m"))
    assert found.status == "reduced"
    assert found.unidentifiable == ("Fc_1", "twin")
    assert found.names[4] == "Fc_1 + twin"
    assert np.allclose(found.parameters, identify(W, tau, NAMES, UNITS).parameters)


def test_a_badly_excited_parameter_predicts_but_is_not_quoted(data):
    W, tau = data
    rng = np.random.default_rng(0)
    extra = W[:, 1] + 1e-4 * rng.standard_normal(len(W))
    found = identify(np.column_stack([W, extra]), tau, (*NAMES, "shadow"), (*UNITS, "kg m"))
    assert set(found.unidentifiable) == {"mx_2", "shadow"}
    assert np.flatnonzero(~found.determined).tolist() == [1, 8]
    assert np.all(found.relative_std[found.determined] <= 0.5)


def test_predicts_from_the_full_regressor(data):
    W, tau = data
    H = np.column_stack([np.zeros(len(W)), W])
    found = identify(H, tau, ("nothing", *NAMES), ("1", *UNITS))
    assert np.allclose(found.predict(H), tau.reshape(-1) - found.residual.reshape(-1))


@pytest.mark.parametrize("loss", ["huber", "tukey"])
def test_the_robust_option_ignores_outliers(data, loss):
    W, tau = data
    spoiled = tau.copy()
    spoiled[::25] += 200.0
    found = identify(W, spoiled, NAMES, UNITS, robust=loss)
    assert np.all(np.abs(found.parameters - TRUTH) < 6 * found.std)
    assert np.all(found.std < 0.3)
    assert loss in found.method


def test_a_prior_determines_what_the_data_do_not(data):
    W, tau = data
    H = np.column_stack([W, np.zeros(len(W))])
    prior = Prior.independent(np.append(TRUTH, 5.0), np.append(np.full(8, 10.0), 0.1))
    found = identify(H, tau, (*NAMES, "unseen"), (*UNITS, "1"), prior=prior)
    assert found.parameters[-1] == pytest.approx(5.0)
    assert found.std[-1] == pytest.approx(0.1)


def test_refuses_a_stack_that_determines_nothing():
    with pytest.raises(NotIdentifiable, match="a, b"):
        identify(np.zeros((8, 2)), np.ones((4, 2)), ("a", "b"), ("1", "1"))
