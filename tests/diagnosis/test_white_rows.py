"""How rows are laid out: what is held out, which rows go together, and how much each counts."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from oed.diagnosis.setup import pose
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set


def _rows(dataset):
    return pose(dataset, TorqueModel.standard(dataset.robot), names=("stribeck",))[0].rows


@pytest.fixture(scope="module")
def rows():
    return _rows(data_set(21, repetitions=2))


def _by_recording(rows, values):
    return np.split(values, np.cumsum([p.rows for p in rows.prepared])[:-1])


def test_the_last_quarter_of_each_recording_is_held_out_where_none_is_for_validation():
    rows = _rows(data_set(21, repetitions=2, roles=("estimation", "estimation", "test")))
    for held in _by_recording(rows, rows.held_out):
        assert held.mean() == pytest.approx(0.25, abs=1 / len(held))
        assert (np.diff(held.astype(int)) >= 0).all()
    assert np.array_equal(rows.fitted, ~rows.held_out)


def test_rows_share_a_phase_where_a_period_lies_between_them_and_no_others_do(rows):
    own = _by_recording(rows, rows.phase)
    for one, other in pairwise(own):
        assert not set(one) & set(other)
    for phase, prepared in zip(own, rows.prepared, strict=True):
        a_period = round(prepared.period * prepared.band.analysis_rate)
        assert np.array_equal(phase[a_period:], phase[:-a_period])
        assert len(set(phase)) == a_period


def test_a_row_counts_as_many_as_rows_without_doubt_tell_as_much(rows):
    """Information of a constant is that of its square; beside doubt of the direction it is less."""
    sure = dataclasses.replace(rows.rows, weights=np.ones_like(rows.rows.weights))
    column = [np.ones((len(p.motion), 1)) for p in rows.prepared]
    for joint in range(2):
        told, whole = (r.whiten_fine(column, joint)[:, 0] ** 2 for r in (rows.rows, sure))
        assert rows.counts[joint] * whole == pytest.approx(told, abs=1e-12)
        assert 0 < np.sum(rows.counts[joint] < 0.5) < np.sum(rows.counts[joint] > 0.5)


@pytest.mark.parametrize(
    ("correlated", "length"),
    [
        (0.0, "half a second"),
        (20.2, 40),
        (1e6, 50),  # a twelfth of 601 phases
    ],
)
def test_blocks_are_twice_as_long_as_misfit_is_correlated_within_bounds(rows, correlated, length):
    if length == "half a second":
        length = int(0.5 * rows.prepared[0].band.analysis_rate)
        assert 2 < length < 40
    phases = np.arange(rows.phase.size) % 601
    blocks = dataclasses.replace(rows, phase=phases).blocks(correlated)
    assert np.array_equal(blocks, phases // length)
