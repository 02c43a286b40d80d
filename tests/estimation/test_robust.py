import numpy as np
import pytest
from scipy import stats
from scipy.optimize import minimize

from oed.estimation.covariance import estimate_covariance
from oed.estimation.least_squares import batch_least_squares
from oed.estimation.robust import robust_least_squares
from tests.estimation.planar_arm import DEVIATIONS, TRUTH, planar_regressor, torque, white_noise


def contaminated(rng, samples, share=0.05):
    W = planar_regressor(rng, samples)
    hit = rng.random((samples, 2)) < share
    return W, torque(W, white_noise(rng, samples) + 30 * hit * rng.standard_normal((samples, 2)))


@pytest.mark.parametrize("loss", ["huber", "tukey"])
def test_outliers_move_it_less_than_least_squares(loss):
    rng = np.random.default_rng(0)
    plain, robust = [], []
    for _ in range(20):
        W, y = contaminated(rng, 200)
        length = np.linalg.norm(W, axis=0)
        least_squares = batch_least_squares(W, y, 2, noise=DEVIATIONS**2)
        plain.append(length * (least_squares.parameters - TRUTH))
        found = robust_least_squares(W, y, 2, loss=loss, tolerance=1e-4)
        robust.append(length * (found.solution.parameters - TRUTH))
    # Theory: the outliers multiply the variance of least squares by 1 + 0.05 * 30^2 = 46.
    assert np.linalg.norm(robust) < np.linalg.norm(plain) / 4


def test_huber_minimises_the_huber_loss_at_its_scale():
    rng = np.random.default_rng(1)
    W, y = contaminated(rng, 200)
    found = robust_least_squares(W, y, 2)
    scale = np.tile(np.sqrt(found.variances), 200)

    def loss(x):
        size = np.abs((y - W @ x) / scale)
        return np.sum(np.where(size < 1.345, size**2 / 2, 1.345 * size - 1.345**2 / 2))

    def slope(x):
        return -W.T @ (np.clip((y - W @ x) / scale, -1.345, 1.345) / scale)

    best = minimize(loss, TRUTH, jac=slope, method="BFGS", options={"gtol": 1e-6})
    assert np.allclose(found.solution.parameters, best.x, rtol=1e-4, atol=1e-4)


def test_tukey_gives_gross_outliers_no_weight():
    rng = np.random.default_rng(2)
    W = planar_regressor(rng, 300)
    noise = white_noise(rng, 300)
    noise[::17, 0] += 1000
    found = robust_least_squares(W, torque(W, noise), 2, loss="tukey")
    assert not found.weights[::17, 0].any()
    assert np.median(found.weights) > 0.9


@pytest.mark.parametrize("loss", ["huber", "tukey"])
def test_intervals_cover_the_truth_despite_outliers(loss):
    rng = np.random.default_rng(4)
    hits = []
    for _ in range(50):
        W, y = contaminated(rng, 200)
        found = robust_least_squares(W, y, 2, loss=loss, tolerance=1e-4)
        spread = estimate_covariance(
            found.pseudo_regressor,
            found.pseudo_residual,
            found.solution.posterior_factor,
            method="white",
        )
        reach = stats.t.ppf(0.975, spread.degrees_of_freedom) * np.sqrt(np.diag(spread.covariance))
        hits.append(np.abs(found.solution.parameters - TRUTH) <= reach)
    assert 0.92 <= np.mean(hits) <= 0.98
