import numpy as np
import pytest

from oed.dynamics.motion import random_motion
from oed.estimation.feasible.data_factor import DataFactor
from tests.estimation.feasible.cases import data_of, small_model, true_parameters


def test_misfit_is_that_of_all_rows():
    model, rng = small_model(), np.random.default_rng(1)
    motion = random_motion(model.robot, 60, rng)
    torque = rng.normal(size=(60, 3))
    variances = np.array([0.5, 2.0, 3.0])
    data = DataFactor.of(model.regressor(motion), torque, variances)
    parameters = rng.normal(size=len(model.parameters))
    residual = torque - model.torque(parameters, motion)
    assert data.misfit(parameters) == pytest.approx(np.mean(residual**2 / variances))
    assert data.rows == 180


def test_joined_parts_are_the_whole():
    model, rng = small_model(), np.random.default_rng(2)
    motion = random_motion(model.robot, 60, rng)
    torque, variances = rng.normal(size=(60, 3)), np.ones(3)

    def factor(samples):
        return DataFactor.of(model.regressor(motion[samples]), torque[samples], variances)

    whole = factor(slice(None))
    joined = DataFactor.join([factor(slice(0, 20)), factor(slice(20, 60))])
    of_parts, of_all = (data.triangle.T @ data.triangle for data in (joined, whole))
    assert np.allclose(of_parts, of_all)
    assert joined.rows == whole.rows


def test_a_part_may_count_twice():
    model, rng = small_model(), np.random.default_rng(3)
    data = data_of(model, true_parameters(model, rng), rng, noise=1.0)
    doubled = DataFactor.join([data, data])
    parameters = rng.normal(size=len(model.parameters))
    assert doubled.misfit(parameters) == pytest.approx(data.misfit(parameters))


def test_refuses_nothing():
    with pytest.raises(ValueError, match="no data"):
        DataFactor.join([])
