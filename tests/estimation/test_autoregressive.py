import numpy as np
import pytest
from scipy.linalg import toeplitz

from oed.estimation.autoregressive import AutoregressiveNoise, levinson
from oed.estimation.autoregressive_fit import fit_autoregressive_noise
from oed.estimation.row_pieces import RowPieces
from tests.estimation.planar_arm import autoregressive_noise

NOISE = AutoregressiveNoise(
    (np.array([1.0, -0.8]), np.array([1.0, -0.5, 0.2])), np.array([[1.0, 0.3], [0.3, 0.5]])
)


def test_autocovariance_of_order_one_in_closed_form():
    gamma = NOISE.autocovariance(6)[:, 0]
    assert np.allclose(gamma, 0.8 ** np.arange(6) / (1 - 0.64), rtol=1e-6)


def test_levinson_solves_the_yule_walker_equations():
    gamma = NOISE.autocovariance(3)[:, 1]
    polynomial, variance = levinson(gamma, 2)
    assert np.allclose(polynomial[1:], -np.linalg.solve(toeplitz(gamma[:2]), gamma[1:]))
    assert np.allclose(polynomial, [1.0, -0.5, 0.2], atol=1e-6)
    assert variance[-1] == pytest.approx(0.5, rel=1e-5)


def test_cover_is_the_toeplitz_covariance():
    samples = 30
    gamma = NOISE.autocovariance(samples)
    for joint in range(2):
        unit = np.zeros((samples, 2, samples))
        unit[:, joint] = np.eye(samples)
        omega = NOISE.cover(unit)[:, joint]
        assert np.allclose(omega, toeplitz(gamma[:, joint]), atol=1e-5)


def test_fit_undoes_the_colour_that_regression_takes():
    rng = np.random.default_rng(0)
    samples, t = 400, np.arange(400) / 400
    # Slow columns take the lowest frequencies, where this noise has most of its power.
    slow = np.column_stack([np.cos(np.pi * k * t) for k in range(10)])
    Q, _ = np.linalg.qr(slow)
    influence = RowPieces.of(np.concatenate([Q, np.zeros_like(Q)], axis=1).reshape(-1, 10), 2)
    naive, fitted = [], []
    for _ in range(60):
        noise = autoregressive_noise(rng, samples, 0.9)
        residual = noise - np.column_stack([Q @ (Q.T @ noise[:, 0]), np.zeros(samples)])
        naive.append(np.var(residual[:, 0]))
        fitted.append(fit_autoregressive_noise(influence, residual).autocovariance(1)[0, 0])
    assert np.mean(naive) < 0.7
    assert 0.85 < np.mean(fitted) < 1.15
