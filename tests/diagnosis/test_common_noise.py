"""The bias that noise in motion and torque alike brings, held against what fits are wrong by."""

import numpy as np
import pytest

from oed.diagnosis.evidence.common_noise import bias_from, moments_of_mean
from oed.diagnosis_new.noise.linear_fit import project

TRUTH = np.array([2.0, -1.0])
REPETITIONS, ROWS = 6, 800


def experiment(rng, spread, feedback):
    """Columns with noise, and a torque whose noise is partly that of the first column."""
    t = np.arange(ROWS)
    clean = np.stack([np.sin(0.05 * t), np.cos(0.031 * t)], axis=1)
    noise = np.zeros((REPETITIONS, ROWS, 2))
    noise[:, :, 0] = spread * rng.standard_normal((REPETITIONS, ROWS))
    columns = clean + noise
    torque = clean @ TRUTH + 0.3 * rng.standard_normal((REPETITIONS, ROWS))
    torque = torque + feedback * noise[:, :, 0]
    return columns[:, None], torque[:, None]


@pytest.mark.parametrize(
    ("spread", "feedback"), [(0.0, 0.0), (0.8, 0.0), (0.8, -1.5), (0.8, 2.0), (0.3, 4.0)]
)
def test_bias_is_what_fits_to_the_mean_are_wrong_by(spread, feedback):
    rng = np.random.default_rng(5)
    errors, told = [], []
    for _ in range(60):
        columns, torque = experiment(rng, spread, feedback)
        fit = project(columns.mean(axis=0))
        found = fit.inverse @ fit.coordinates(torque.mean(axis=0))
        told.append(bias_from(fit, *moments_of_mean(columns, torque - columns @ found)))
        errors.append(found - TRUTH)
    scatter = np.std(errors, axis=0) / np.sqrt(len(errors))
    np.testing.assert_allclose(
        np.mean(told, axis=0), np.mean(errors, axis=0), atol=4 * scatter.max(), rtol=0.05
    )
    if spread and feedback != 2.0:  # noise that obeys the true law biases nothing
        assert abs(np.mean(errors, axis=0)[0]) > 10 * scatter[0]
