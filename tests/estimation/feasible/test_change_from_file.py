"""What moved from the file, and whether the data asked for it."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.motion import random_motion
from oed.estimation.feasible.change_from_file import (
    Moved,
    _slopes,
    _values,
    deviations_from_data,
    link_changes,
)
from oed.estimation.feasible.data_factor import DataFactor
from oed.estimation.feasible.feasible_set import FeasibleSet
from oed.estimation.feasible.problem import build_problem
from oed.estimation.feasible.regularisation import Regularisation
from oed.robot.inertia import pseudo_inertia, transform_parameters
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


def inertia(change):
    assert change.inertia is not None
    return change.inertia


def changes_of(changed):
    """From the file of three links, of which one came out otherwise, with samples that scatter by a tenth."""
    model, problem, _ = problem_of()
    before = model.robot.parameters
    after = changed(before.copy())
    samples = np.tile(np.append(after, np.ones(9)), (5, 1)) * np.linspace(0.9, 1.1, 5)[:, None]
    links = tuple(joint.link for joint in model.robot.joints)
    changes = link_changes(links, before, after, samples, problem)
    assert [change.link for change in changes] == [*links, "all links"]
    return before, after, changes


def test_a_mass_that_moved_undetermined_is_told_with_interval_and_file():
    def heavier(body):
        body[:10] *= 30.0  # undetermined, and thirty times the file's
        return body

    before, after, (first, second, third, total) = changes_of(heavier)
    assert [moved.name for moved in first.unreasonable] == ["mass", "inertia"]
    assert second.warning == third.warning == ""
    assert total.mass.after == pytest.approx(after[::10].sum())
    assert bool(total.warning) == (total.mass.after > 1.3 * total.mass.before)
    assert f"mass {after[0]:.3g} kg, in the file {before[0]:.3g} kg" in first.warning
    assert "no torque in the data depends on it" in first.warning
    # Five draws whose standard deviation is 0.079: 2.776 of them, by Student's t.
    assert first.mass.interval == pytest.approx(after[0] * np.array([0.7805, 1.2195]), rel=1e-3)
    # Thirty times the same body: its centre stays, its moments are thirty times as large.
    for moved in first.centre:
        assert moved.after == pytest.approx(moved.before)
    assert inertia(first).after == pytest.approx(30 * inertia(first).before)


@pytest.mark.parametrize(
    ("factor", "is_told"), [(0.69, True), (0.71, False), (1.29, False), (1.31, True)]
)
def test_a_mass_may_be_off_as_makers_are_where_no_torque_tells(factor, is_told):
    def heavier(body):
        body[0] *= factor
        return body

    _, _, (first, *_) = changes_of(heavier)
    assert ("mass" in [moved.name for moved in first.unreasonable]) == is_told


@pytest.mark.parametrize(("share", "is_told"), [(0.9, False), (1.1, True)])
def test_a_centre_may_move_by_the_radius_of_gyration_where_no_torque_tells(share, is_told):
    """Along its own vertical axis the first link's centre is in no torque; its height is free."""

    def higher(body):
        own = body[:10]
        mean = np.trace(central(own)) / 3
        shift = share * np.sqrt(mean / own[0])
        body[:10] = transform_parameters(own, np.eye(3), np.array([0.0, 0.0, shift]))
        return body

    _, _, (first, *_) = changes_of(higher)
    assert [moved.name for moved in first.unreasonable] == (["centre z"] if is_told else [])
    assert inertia(first).after == pytest.approx(inertia(first).before)
    if is_told:
        low, high = first.centre[2].interval
        assert low <= first.centre[2].after <= high
        assert "centre z" in first.warning
        assert " m, in the file " in first.warning


@pytest.mark.parametrize(
    ("factor", "is_told"), [(0.45, True), (0.6, False), (1.9, False), (2.1, True)]
)
def test_an_inertia_may_double_or_halve_where_no_torque_tells(factor, is_told):
    def wider(body):
        own = body[:10]
        body[4:10] += ((factor - 1) * central(own))[np.triu_indices(3)]
        return body

    _, _, (first, *_) = changes_of(wider)
    assert [moved.name for moved in first.unreasonable] == (["inertia"] if is_told else [])
    assert inertia(first).after == pytest.approx(factor * inertia(first).before)


def test_what_the_data_determine_may_move_as_far_as_it_will():
    moved = Moved("centre x", "m", 0.0, 0.5, np.array([0.49, 0.51]), 0.01, 0.1, (-0.1, 0.1))
    assert moved.is_determined
    assert not moved.is_unreasonable
    assert dataclasses.replace(moved, deviation=0.04).is_unreasonable


def central(body):
    """Inertia about the centre of mass."""
    pseudo = pseudo_inertia(body)
    centre = pseudo[:3, 3] / body[0]
    spread = pseudo[:3, :3] - body[0] * np.outer(centre, centre)
    return np.trace(spread) * np.eye(3) - spread


def test_values_are_those_of_the_tensors_and_slopes_those_of_the_values():
    rng = np.random.default_rng(53)
    bodies = small_model().robot.parameters + 1e-3 * rng.standard_normal(30)
    for body, found in zip(bodies.reshape(-1, 10), _values(bodies.reshape(-1, 10)), strict=True):
        assert found[:4] == pytest.approx([body[0], *body[1:4] / body[0]])
        assert found[4] == pytest.approx(np.linalg.eigvalsh(central(body)).mean())
    slopes = _slopes(bodies, 33)
    for k in range(30):
        step = 1e-6 * np.eye(30)[k]
        by_difference = [_values((bodies + s * step).reshape(-1, 10)).ravel() for s in (1, -1)]
        expected = (by_difference[0] - by_difference[1]) / 2e-6
        assert slopes[:-1, k] == pytest.approx(expected, abs=1e-6)
    assert np.flatnonzero(slopes[-1]).tolist() == [0, 10, 20]
