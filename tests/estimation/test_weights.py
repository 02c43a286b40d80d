import numpy as np
import pytest

from oed.estimation.weights import (
    variances_from_repetitions,
    variances_from_residuals,
)
from tests.estimation.planar_arm import DEVIATIONS, planar_regressor, torque, white_noise


def test_repetitions_give_the_papers_formula():
    rng = np.random.default_rng(0)
    tau = rng.standard_normal((20, 80, 3)) * [1.0, 2.0, 0.5] + np.sin(np.arange(80))[:, None]
    mean = tau.mean(axis=0)
    by_hand = [
        sum((tau[j, k, i] - mean[k, i]) ** 2 for k in range(80) for j in range(20)) / (80 * 19)
        for i in range(3)
    ]
    assert np.allclose(variances_from_repetitions(tau), by_hand, rtol=1e-12)


def test_repetitions_give_an_unbiased_variance_whatever_the_motion():
    rng = np.random.default_rng(1)
    motion = np.sin(np.linspace(0, 2 * np.pi, 80))[:, None] * [10.0, 1.0]
    sigma = np.array([0.3, 2.0])
    found = [
        variances_from_repetitions(motion + sigma * rng.normal(size=(6, 80, 2))) for _ in range(500)
    ]
    # 400 degrees of freedom x 500 draws: standard error sqrt(2 / 200 000) = 0.3 %.
    assert np.allclose(np.mean(found, axis=0), sigma**2, rtol=0.015)


def test_one_repetition_has_no_variance():
    with pytest.raises(ValueError, match="at least two"):
        variances_from_repetitions(np.zeros((1, 80, 2)))


def test_residual_variances_are_unbiased_with_few_samples():
    rng = np.random.default_rng(1)
    W = planar_regressor(rng, 30)
    found = np.array(
        [variances_from_residuals(W, torque(W, white_noise(rng, 30)), 2) for _ in range(150)]
    )
    error = found.std(axis=0) / np.sqrt(len(found))
    assert np.all(np.abs(found.mean(axis=0) - DEVIATIONS**2) < 4 * error)


def test_refuses_a_joint_without_a_degree_of_freedom():
    W = np.eye(4)
    with pytest.raises(ValueError, match="no degree of freedom"):
        variances_from_residuals(W, np.arange(4.0), 2)
