"""Averages over repetitions, and the variance they reveal."""

import numpy as np
import pytest

from oed.experiment.signals.repetitions import average_repetitions, fold, fold_by_index


def test_variance_is_the_papers():
    folded = np.random.default_rng(0).normal(size=(4, 10, 2))
    average = average_repetitions(folded)
    by_hand = sum(
        (folded[j, k] - folded[:, k].mean(axis=0)) ** 2 for j in range(4) for k in range(10)
    ) / (10 * 3)
    assert np.allclose(average.variance, by_hand, rtol=1e-12)
    assert average.degrees_of_freedom == 30


def test_variance_is_unbiased_whatever_the_motion():
    rng = np.random.default_rng(1)
    motion = np.sin(np.linspace(0, 2 * np.pi, 80))[:, None] * [10.0, 1.0]
    sigma = np.array([0.3, 2.0])
    estimates = np.array(
        [
            average_repetitions(motion + sigma * rng.normal(size=(6, 80, 2))).variance
            for _ in range(500)
        ]
    )
    # 400 degrees of freedom x 500 draws: standard error sqrt(2 / 200 000) = 0.3 %.
    assert np.allclose(estimates.mean(axis=0), sigma**2, rtol=0.015)


def test_folding_by_period_and_by_index_agree_on_a_uniform_grid():
    t = np.arange(60) / 20
    x = np.random.default_rng(2).normal(size=(60, 2))
    folded = fold(t, x, period=1.0, phases=20)
    assert folded.shape == (3, 20, 2)
    assert np.allclose(folded, fold_by_index(x, np.arange(60) // 20), rtol=0, atol=1e-9)


def test_folding_irregular_time_aligns_the_phases():
    t = np.cumsum(np.random.default_rng(3).uniform(0.002, 0.006, 1100))
    x = np.sin(2 * np.pi * (t - t[0]))[:, None]
    folded = fold(t, x, period=1.0, phases=50)
    expected = np.sin(2 * np.pi * np.arange(50) / 50)[:, None]
    assert len(folded) == int(t[-1] - t[0])
    assert np.allclose(folded, expected, rtol=0, atol=1e-5)


def test_refuses_what_cannot_be_averaged():
    with pytest.raises(ValueError, match="at least 2"):
        average_repetitions(np.zeros((1, 5, 2)))
    with pytest.raises(ValueError, match="no whole period"):
        fold(np.arange(10) / 10, np.zeros((10, 1)), period=5.0, phases=10)
    with pytest.raises(ValueError, match="2 to 3 samples"):
        fold_by_index(np.zeros((5, 1)), np.array([0, 0, 0, 1, 1]))
