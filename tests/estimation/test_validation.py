import numpy as np
import pytest

from oed.estimation.validation import validate


def test_states_rms_as_the_paper_does():
    measured = np.array([[3.0, 1.0], [-3.0, -1.0], [3.0, 1.0], [-3.0, -1.0]])
    found = validate(measured - [0.3, 0.5], measured)
    assert np.allclose(found.rms, [0.3, 0.5])
    assert np.allclose(found.relative_rms, [0.1, 0.5])
    assert np.allclose(found.r_squared, [0.99, 0.75])
    assert found.overall_rms == pytest.approx(np.sqrt((0.09 + 0.25) / 2))
    assert found.overall_relative_rms == pytest.approx(np.sqrt(0.34 / 10))
    assert found.samples == 4


def test_a_steady_torque_counts_in_the_relative_error_and_not_in_r_squared():
    measured = np.array([[5.0], [3.0], [5.0], [3.0]])  # holds 4 N m against gravity
    found = validate(measured - 0.5, measured)
    assert found.relative_rms[0] == pytest.approx(0.5 / np.sqrt(17.0))
    assert found.r_squared[0] == pytest.approx(1 - 0.25 / 1.0)


def test_a_joint_without_torque_has_no_relative_error():
    measured = np.column_stack([np.zeros(5), np.arange(5.0)])
    found = validate(np.ones((5, 2)), measured)
    assert np.isnan(found.relative_rms[0])
    assert np.isnan(found.r_squared[0])
    assert found.rms[0] == 1.0


def test_refuses_what_cannot_be_compared():
    with pytest.raises(ValueError, match="against"):
        validate(np.zeros((0, 2)), np.zeros((0, 2)))
    with pytest.raises(ValueError, match="not finite"):
        validate(np.full((5, 2), np.nan), np.zeros((5, 2)))
