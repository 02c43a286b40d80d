"""Projections and white columns against what they stand for."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.evidence import model
from oed.diagnosis.evidence.columns import pieces, white_effect, white_model
from oed.diagnosis.evidence.fit import project
from oed.diagnosis.evidence.model import fit
from oed.diagnosis.evidence.term import Term
from oed.diagnosis.rows.white_rows import WhiteRows
from oed.diagnosis.setup import pose
from oed.dynamics.effects import RotorInertia
from oed.dynamics.effects.delay import FilterLag
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.noise_floor.weighted_rows import Rows
from tests.diagnosis.arm import data_set


@pytest.fixture(scope="module")
def problem():
    dataset = data_set(21, repetitions=2)
    found, _, _ = pose(dataset, TorqueModel.standard(dataset.robot), names=("stribeck",))
    return found


def test_rows_are_of_estimation_and_validation_alone(problem):
    assert {p.role for p in problem.rows.prepared} == {"estimation", "validation"}
    assert not np.any(problem.rows.fitted & problem.rows.held_out)


def test_what_no_log_resolves_at_a_reversal_stands_beside_every_model(problem):
    for own in (problem, problem.means):
        assert own.nuisances.shape == (2, own.rows.torque.shape[1], 4)
        assert np.all(own.nuisances[0, :, 2:] == 0)
        assert np.all(own.nuisances[1, :, :2] == 0)
        late = project(own.rows.torque, own.nuisances, own.rows.fitted, np.ones(2))
        assert late.basis.shape[2] == 4


def test_residual_is_that_of_weighted_least_squares(problem):
    rows = problem.rows
    columns = white_model(problem.base, problem.columns, rows)
    variance = np.array([1.0, 4.0])
    found = project(rows.torque, columns, rows.fitted, variance)
    X = np.concatenate([columns[j, rows.fitted] / np.sqrt(v) for j, v in enumerate(variance)])
    y = np.concatenate([rows.torque[j, rows.fitted] / np.sqrt(v) for j, v in enumerate(variance)])
    assert found.coefficients == pytest.approx(np.linalg.lstsq(X, y, rcond=None)[0], rel=1e-6)


def test_information_beside_the_model_is_that_of_a_refit(problem):
    rows = problem.rows
    columns = white_model(problem.base, problem.columns, rows)
    found = project(rows.torque, columns, rows.fitted, np.ones(2))
    further = white_effect(RotorInertia(1), problem.base, rows)
    beside = found.beside(further)
    A, g = beside.information, beside.score
    more = np.zeros((2, rows.torque.shape[1], 1))
    more[1] = further[1]
    refit = project(rows.torque, np.concatenate([columns, more], axis=2), rows.fitted, np.ones(2))
    assert g / A[0] == pytest.approx(refit.coefficients[-1:], rel=1e-5)
    left = np.sum(refit.residual[:, rows.fitted] ** 2, axis=1)
    assert beside.left_by(g / A[0]) == pytest.approx(left, rel=1e-6)
    fall = np.sum(found.residual[:, rows.fitted] ** 2) - np.sum(refit.residual[:, rows.fitted] ** 2)
    assert fall == pytest.approx(float(g @ np.linalg.solve(A, g)), rel=1e-5)


def test_what_a_column_alone_gives_is_what_all_others_leave_of_it(problem):
    rows = problem.rows
    columns = white_model(problem.base, problem.columns, rows)
    used, variance, last = rows.fitted, np.array([1.0, 4.0]), columns.shape[2] - 1
    found = project(rows.torque, columns, used, variance)
    X = np.concatenate([columns[j, used] / np.sqrt(v) for j, v in enumerate(variance)])
    own = X[:, last] * found.coefficients[last]
    left = own - X[:, :last] @ np.linalg.lstsq(X[:, :last], own, rcond=None)[0]
    given = found.beyond_others(slice(last, last + 1))[:, used] / np.sqrt(variance)[:, None]
    assert given.ravel() == pytest.approx(left, abs=1e-8 * np.abs(own).max())
    # The same of columns that the model does not have yet.
    rest = project(rows.torque, columns[:, :, :last], used, variance)
    beside = rest.beside({j: columns[j, :, last:] for j in range(2)})
    power = beside.power(found.coefficients[last:])
    squares = np.sum((given * np.sqrt(variance)[:, None]) ** 2, axis=1)
    assert power == pytest.approx(squares, rel=1e-6)


def test_a_fit_after_another_is_the_fit_itself(problem):
    rows = problem.rows
    columns = white_model(problem.base, problem.columns, rows)
    before = project(rows.torque, columns, rows.fitted, np.ones(2))
    changed = columns.copy()
    changed[1, :, -1] **= 3
    for torque in (rows.torque, 2 * rows.torque):
        for used in (rows.fitted, rows.held_out):
            own = project(torque, changed, used, np.array([1.0, 4.0]), before=before)
            alone = project(torque, changed, used, np.array([1.0, 4.0]))
            assert own.coefficients == pytest.approx(alone.coefficients, rel=1e-12)


def test_a_prior_is_as_many_rows_of_zeros(problem):
    rows = problem.rows
    columns = white_model(problem.base, problem.columns, rows)
    count = columns.shape[2]
    precision = 100.0 * np.eye(count)
    found = project(rows.torque, columns, rows.fitted, np.ones(2), precision)
    X = columns[:, rows.fitted].reshape(-1, count)
    y = rows.torque[:, rows.fitted].ravel()
    assert found.coefficients == pytest.approx(
        np.linalg.solve(X.T @ X + precision, X.T @ y), rel=1e-6
    )


def test_pieces_of_a_recording_give_the_rows_of_the_whole(problem, monkeypatch):
    whole = white_model(problem.base, problem.columns, problem.rows)
    lagged = problem.base.with_measurement(FilterLag(0.01))
    late = white_model(lagged, problem.columns, problem.rows)
    monkeypatch.setattr("oed.diagnosis.evidence.columns.SAMPLES", 1500)
    assert len(list(pieces(problem.rows.prepared[0], remembers=False))) > 2
    assert np.abs(white_model(problem.base, problem.columns, problem.rows) - whole).max() < 1e-9
    again = white_model(lagged, problem.columns, problem.rows)
    assert np.abs(again - late).max() < 1e-6 * np.abs(late).max()


def test_blocks_hold_all_repetitions_of_a_phase(problem):
    rows = problem.rows
    blocks = rows.blocks(1.0)
    first = rows.prepared[0]
    phase, own = np.floor(first.phase / 0.5), blocks[: first.rows]
    shared = [len(np.unique(own[phase == p])) for p in np.unique(phase)]
    assert max(shared) <= 2
    assert isinstance(rows.rows, Rows)
    assert isinstance(rows, WhiteRows)


def test_the_power_of_a_term_is_the_mean_square_of_what_it_gives_to_the_rows_that_count(problem):
    law = next(c for c in problem.names if c.label == "stribeck@1")
    fitted = fit(problem, (Term(law, (0.1, 2.0, 0.0)),), problem.rows.fitted)
    (place,), (size,) = fitted.places, fitted.coefficients
    white = white_effect(law.effect(problem.context, (0.1, 2.0, 0.0)), problem.base, problem.rows)
    given = white[0][:, 0] * size[0]
    expected = given @ given / problem.rows.counts[0].sum()
    assert expected > 0
    assert fitted.power(place) == pytest.approx([expected, 0.0])


@pytest.mark.parametrize(("step", "is_moved"), [(0.005, False), (0.03, True), (0.08, True)])
def test_a_step_is_taken_where_rows_tell_what_it_leaves_out(step, is_moved):
    """Of what a step d of a gain of 0.05 gives, its first order leaves out the share d / 0.05."""
    dataset = data_set(21, repetitions=2)
    base = TorqueModel.standard(dataset.robot)
    problem = pose(dataset, base, names=("torque_gain",))[0].sparse
    law = next(c for c in problem.names if c.label == "torque_gain@1")
    own = fit(problem, (Term(law, (1.0,), steps=((0.05,),)),), problem.rows.fitted)
    term, (place,) = dataclasses.replace(own.terms[0], steps=((0.05,),)), own.places
    # Alike in all rows, and so large that of a step of 0.01 the squares left out are a tenth of a row's.
    height = np.sqrt(0.1 * own.variance[0] / own.projection.used.sum()) / (0.01 * 0.01 / 0.05)
    columns, coefficients = (
        np.zeros_like(own.projection.columns),
        own.projection.coefficients.copy(),
    )
    columns[0, :, place], coefficients[place] = height, step
    projection = dataclasses.replace(own.projection, columns=columns, coefficients=coefficients)
    moved = dataclasses.replace(own, projection=projection)
    assert model._moves(moved, term, place, settled=False) is is_moved
    assert model._moves(moved, term, place, settled=True)
