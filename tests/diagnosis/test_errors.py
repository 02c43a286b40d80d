"""Intervals of errors against the deviation that a mean of squares has."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.diagnose import _unlocated
from oed.diagnosis.inference.errors import Predictor, RoleErrors, compare
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import data_set

SIZES = np.array([2.0, 0.1])  # [N m]


class _Nothing(Predictor):
    """Predicts no torque: what is measured is what is left."""

    def torque(self, prepared):
        return np.zeros_like(prepared.torque)


def _left(kept=1.0):
    """A recording whose torque is drawn anew every half second, and stays until the next."""
    rng = np.random.default_rng(8)
    dataset = data_set(3, repetitions=6, roles=("estimation",))
    (own,) = prepare(dataset.estimation)
    assert own.valid.all()
    length = round(0.5 * own.band.analysis_rate)
    draws = rng.normal(size=(-(-own.rows // length), 2)) * SIZES
    torque = kept * np.repeat(draws, length, axis=0)[: own.rows]
    return dataclasses.replace(own, torque=torque), len(draws), dataset


def test_an_interval_is_as_wide_as_blocks_that_go_together_have_it():
    own, blocks, dataset = _left()
    nothing = _Nothing(TorqueModel.standard(dataset.robot), np.zeros(0))
    found = compare(
        "test",
        [own],
        [np.ones_like(own.torque)],
        before=nothing,
        after=nothing,
        rng=np.random.default_rng(1),
    )
    assert found.before == pytest.approx(np.sqrt(np.mean(own.torque**2, axis=0)))
    assert found.before == pytest.approx(SIZES, rel=0.2)
    # Of a normal variable's rms from so many draws: sigma / sqrt(2 blocks).
    width = np.diff(found.before_interval, axis=1)[:, 0]
    assert width == pytest.approx(2 * 1.96 * SIZES / np.sqrt(2 * blocks), rel=0.3)
    assert found.change_interval == pytest.approx(0.0, abs=1e-12)


def test_rows_count_by_their_weights():
    own, _, dataset = _left()
    nothing = _Nothing(TorqueModel.standard(dataset.robot), np.zeros(0))
    weights = np.random.default_rng(2).uniform(size=own.torque.shape)
    how = {"before": nothing, "after": nothing, "rng": np.random.default_rng(1)}
    found = compare("test", [own], [weights], **how)
    expected = np.sqrt(np.average(own.torque**2, axis=0, weights=weights))
    assert found.after == pytest.approx(expected)
    assert found.counted == pytest.approx(weights.mean(axis=0))


@pytest.mark.parametrize("role", ["estimation", "validation", "test"])
def test_errors_that_the_search_saw_leave_a_joint_unexplained_and_those_of_the_test_do_not(role):
    """A push in an estimation recording is no validation error, and yet the model lacks it."""
    quiet, loud = np.array([1.0, 1.0]), np.array([1.0, 2.1])
    nothing = np.zeros((2, 2))
    errors = [
        RoleErrors(own, quiet, after, after, quiet, nothing, nothing, nothing)
        for own in ("estimation", "validation", "test")
        for after in [loud if own == role else quiet]
    ]
    found = _unlocated((), errors, np.ones(2))
    assert [u.joint for u in found] == ([] if role == "test" else [1])
    assert _unlocated(found, errors, np.ones(2)) == ()
