"""The criterion against closed forms and against draws."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from oed.diagnosis.evidence.criterion import (
    Moments,
    log_score,
    saturated,
    score_dilution,
    worth,
)

ROWS = 400.0


def _problem(seed=0, columns=2, size=0.3):
    rng = np.random.default_rng(seed)
    X = rng.normal(size=(int(ROWS), columns)) * np.arange(1, columns + 1)
    return X, X @ np.full(columns, size) + rng.normal(size=int(ROWS))


def _log_marginal(X, y, precision):
    covariance = np.eye(len(y)) + X @ np.linalg.solve(precision, X.T)
    return multivariate_normal(np.zeros(len(y)), covariance).logpdf(y)


def test_is_the_marginal_likelihood_under_unit_information():
    X, y = _problem(size=0.05)
    A, g = X.T @ X, X.T @ y
    found = worth(
        Moments(A, g, ROWS, gained=float(0.5 * g @ np.linalg.solve(A + A / ROWS, g))), price=0.0
    )
    nothing = norm.logpdf(y).sum()
    assert found.nats == pytest.approx(_log_marginal(X, y, A / ROWS) - nothing, abs=1e-6)
    assert found.coefficients == pytest.approx(np.linalg.solve(A * (1 + 1 / ROWS), g))


def test_a_smooth_term_is_worth_its_marginal_likelihood_under_the_prior_that_it_has():
    X, y = _problem(columns=4, size=0.05)
    A, g = X.T @ X, X.T @ y
    P = 30.0 * np.eye(4) + 5.0
    gained = float(0.5 * g @ np.linalg.solve(A + P, g))
    found = worth(Moments(A, g, ROWS, gained=gained), 0.0, P, chosen=True)
    nothing = norm.logpdf(y).sum()
    assert found.nats == pytest.approx(_log_marginal(X, y, P) - nothing, abs=1e-6)
    assert found.precision == pytest.approx(P)


def test_smoothness_is_that_of_largest_evidence_and_paid_for():
    X, y = _problem(columns=6, size=0.0)
    y = y + X @ np.sin(np.arange(6.0))
    bends = np.diff(np.eye(6), 2, axis=0)
    A, g = X.T @ X, X.T @ y
    found = worth(Moments(A, g, ROWS), 0.0, bends.T @ bends)
    again = worth(Moments(A, g, ROWS), 0.0, found.precision, chosen=True)
    assert again.nats == pytest.approx(found.nats)
    assert again.coefficients == pytest.approx(found.coefficients)
    for factor in (100.0, 0.01):
        other = worth(Moments(A, g, ROWS), 0.0, factor * found.precision, chosen=True)
        assert other.nats < found.nats


def test_pieces_that_hardly_any_row_saw_lie_near_their_neighbours():
    rng = np.random.default_rng(5)
    knots, steps = 8, np.diff(np.eye(8), axis=0)
    curve, penalty = np.sin(np.arange(8.0)), steps.T @ steps
    X = np.eye(knots)[np.repeat(np.arange(knots), 100)]
    seen = np.ones(len(X))
    seen[-200:-100], seen[-100:] = 0.03, 1e-4
    X = X * seen[:, None]
    y = X @ curve + rng.normal(size=len(X))
    y[-200:-100] += 0.3  # as if the curve rose by ten, three deviations of what such rows tell
    found = worth(Moments(X.T @ X, X.T @ y, float(len(X))), 0.0, penalty)
    assert found.coefficients[:-2] == pytest.approx(curve[:-2], abs=0.5)
    assert found.coefficients[-2:] == pytest.approx(curve[-3], abs=1.5)


def test_units_do_not_change_it():
    X, y = _problem()
    scale = np.array([1e-4, 1e3])
    one, other = (worth(Moments(Z.T @ Z, Z.T @ y, ROWS), price=1.0) for Z in (X, X * scale))
    assert one.nats == pytest.approx(other.nats)
    assert one.coefficients == pytest.approx(other.coefficients * scale)


def test_a_column_that_tells_nothing_costs_half_the_log_of_the_rows_and_its_price():
    X, y = _problem(columns=1, size=0.0)
    y = y - X @ np.linalg.lstsq(X, y, rcond=None)[0]
    found = worth(Moments(X.T @ X, X.T @ y, ROWS), price=3.0)
    assert found.nats == pytest.approx(-0.5 * np.log(1 + ROWS) - 3.0, abs=1e-9)


def test_dilution_is_as_much_as_so_many_fewer_rows():
    X, y = _problem(columns=1)
    A, g = X.T @ X, X.T @ y
    diluted = worth(Moments(A, g, ROWS, dilution=4.0), price=0.0)
    fewer = worth(Moments(A / 4, g / 4, ROWS / 4), price=0.0)
    assert diluted.nats == pytest.approx(fewer.nats)


def test_a_smoothing_prior_charges_a_straight_line_less_than_a_wave():
    places = np.linspace(0, 1, 12)
    bends = np.diff(np.eye(12), 2, axis=0)
    A = 50.0 * np.eye(12)
    line, wave = (
        worth(Moments(A, A @ f, 600.0, gained=40.0), 0.0, bends.T @ bends)
        for f in (places, np.cos(40 * places))
    )
    assert line.freedom <= wave.freedom
    assert np.corrcoef(line.coefficients, places)[0, 1] > 0.999


def test_a_fixed_coefficient_has_no_freedom():
    X, y = _problem(columns=1, size=1.0)
    found = worth(Moments(X.T @ X, X.T @ y, ROWS), price=2.0, fixed=True)
    fall = float(y @ y - np.sum((y - X[:, 0]) ** 2))
    assert found.nats == pytest.approx(saturated(fall, ROWS) - 2.0)
    assert found.freedom == 0.0


def test_squares_below_what_is_tolerated_are_noise():
    rows, tolerated = np.array([100.0]), np.array([1.0])
    scores = [log_score(np.array([s * 100.0]), rows, tolerated) for s in (0.5, 1.0, 4.0)]
    assert scores[0] - scores[1] == pytest.approx(25.0)
    assert scores[1] - scores[2] == pytest.approx(50 * np.log(4.0))
    # A joint whose formula is true to less may leave more without blame.
    assert log_score(np.array([400.0]), rows, np.array([4.0])) == pytest.approx(scores[2])


@pytest.mark.parametrize(("memory", "expected"), [(0.0, 1.0), (0.8, 9.0)])
def test_dilution_of_correlated_rows_is_their_variance_inflation(memory, expected):
    # A constant's score among rows of an autoregression: (1 + a) / (1 - a), Bartlett 1935.
    rng = np.random.default_rng(3)
    found = []
    for _ in range(40):
        noise = rng.normal(size=6000)
        left = np.zeros(6000)
        for k in range(1, 6000):
            left[k] = memory * left[k - 1] + noise[k]
        left = left / left.std()
        scores = left.reshape(60, 100).sum(axis=1)[:, None]
        found.append(score_dilution(scores, 1 / 60, np.array([[6000.0]])))
    assert np.mean(found) == pytest.approx(expected, rel=0.15)


def test_false_terms_of_pure_noise_are_worth_nothing():
    rng = np.random.default_rng(5)
    worths = []
    for _ in range(300):
        x, y = rng.normal(size=(2, 500))
        worths.append(
            worth(Moments(np.array([[x @ x]]), np.array([x @ y]), 500.0), np.log(40)).nats
        )
    assert max(worths) < 0


def test_unit_information_is_that_of_one_independent_row():
    X, y = _problem()
    found = worth(Moments(X.T @ X, X.T @ y, ROWS, dilution=4.0), price=0.0)
    assert found.precision == pytest.approx(X.T @ X / (ROWS / 4))
