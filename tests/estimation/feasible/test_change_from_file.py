"""What moved from the file, and whether the data asked for it."""

import numpy as np
import pytest

from oed.dynamics.motion import random_motion
from oed.estimation.feasible.change_from_file import deviations_from_data, link_changes
from oed.estimation.feasible.data_factor import DataFactor
from oed.estimation.feasible.feasible_set import FeasibleSet
from oed.estimation.feasible.problem import build_problem
from oed.estimation.feasible.regularisation import Regularisation
from tests.estimation.feasible.cases import small_model, true_parameters


def problem_of(noise=2.0, samples=200):
    rng = np.random.default_rng(51)
    model = small_model()
    motion = random_motion(model.robot, samples, rng)
    torque = model.torque(true_parameters(model, rng), motion)
    torque = torque + noise * rng.standard_normal(torque.shape)
    variances = np.full(3, noise**2)
    regressor = model.regressor(motion)
    data = DataFactor.of(regressor, torque, variances)
    reference, pull = model.robot.parameters, Regularisation(1e-4)
    problem = build_problem(model, data, FeasibleSet.of(model), reference, pull)
    return model, problem, regressor / noise


def test_deviations_are_those_of_the_textbook():
    model, problem, white = problem_of()
    rng = np.random.default_rng(52)
    # Rows of the regressor are combinations that the data determine, whatever its rank.
    combinations = rng.standard_normal((4, len(white))) @ white
    covariance = np.linalg.pinv(white.T @ white, rcond=1e-12, hermitian=True)
    expected = np.sqrt(np.einsum("ki,ij,kj->k", combinations, covariance, combinations))
    assert deviations_from_data(problem, combinations) == pytest.approx(expected, rel=1e-4)
    names = [parameter.name for parameter in model.parameters]
    alone = np.eye(len(names))[[names.index("m_1"), names.index("Fv_2")]]
    mass, friction = deviations_from_data(problem, alone)
    # The first link turns about its own axis: no torque depends on its mass.
    assert np.isinf(mass)
    assert friction == pytest.approx(
        np.sqrt(covariance[names.index("Fv_2"), names.index("Fv_2")]), rel=1e-4
    )


def test_a_mass_that_moved_undetermined_is_told_with_interval_and_file():
    model, problem, _ = problem_of()
    before = model.robot.parameters
    after = before.copy()
    after[:10] *= 30.0  # undetermined, and thirty times the file's
    samples = np.tile(np.append(after, np.ones(9)), (5, 1)) * np.linspace(0.9, 1.1, 5)[:, None]
    links = tuple(joint.link for joint in model.robot.joints)
    changes = link_changes(links, before, after, samples, problem)
    assert [change.link for change in changes] == [*links, "all links"]
    first, second, third, total = changes
    assert first.is_unreasonable
    assert not second.is_unreasonable
    assert not third.is_unreasonable
    assert total.mass_after == pytest.approx(after[::10].sum())
    assert total.is_unreasonable == (total.mass_after > 2 * total.mass_before)
    assert f"{after[0]:.3g} kg, in the file {before[0]:.3g} kg" in first.warning
    assert "no torque in the data depends on it" in first.warning
    assert first.interval == pytest.approx(after[0] * np.array([0.905, 1.095]), rel=1e-3)
    # Thirty times the same body: its centre stays, its moments are thirty times as large.
    assert first.centre_after == pytest.approx(first.centre_before)
    assert first.inertia_after == pytest.approx(30 * first.inertia_before)
