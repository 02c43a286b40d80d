"""What the estimation motion does not carry to other motions is left at zero, and named."""

import numpy as np
import pytest

from oed.estimation.identify import identify
from oed.estimation.reach import LARGEST_REACH, find_reach
from tests.estimation.planar_arm import JOINTS, NAMES, TRUTH, UNITS, planar_regressor

SAMPLES = 2000


def relative(predicted, measured):
    return np.sqrt(np.mean((predicted - measured) ** 2) / np.mean(measured**2))


def unlike(t_columns, joint, size):
    """A model error that no column describes: it repeats with the motion."""
    error = np.zeros(t_columns.shape[0]).reshape(-1, JOINTS)
    phase = np.linspace(0, 40 * np.pi, len(error))
    error[:, joint] = size * np.sin(phase)
    return error.reshape(-1)


def test_a_motion_like_the_others_determines_all():
    rng = np.random.default_rng(5)
    fitted, other = planar_regressor(rng, SAMPLES), planar_regressor(rng, SAMPLES)
    torque = (fitted @ TRUTH).reshape(-1, JOINTS)
    usual = np.sqrt(np.mean(torque**2, axis=0))
    reach = find_reach(fitted, [other], 0.05 * usual, usual)
    assert reach.lost == 0
    assert len(reach.prior(SAMPLES).factor) == 0


def test_units_do_not_count():
    rng = np.random.default_rng(6)
    fitted, other = planar_regressor(rng, SAMPLES), planar_regressor(rng, SAMPLES)
    scale = 10.0 ** rng.uniform(-4, 4, len(TRUTH))
    one = find_reach(fitted, [other], np.ones(2), np.full(2, 5.0))
    same = find_reach(fitted * scale, [other * scale], np.ones(2), np.full(2, 5.0))
    np.testing.assert_allclose(same.factor, one.factor, rtol=1e-6)


def test_the_factor_is_what_an_error_in_one_direction_foretells():
    """Of one column: twice as fast elsewhere, error a tenth of the torque."""
    fitted = np.ones((100, 1))
    reach = find_reach(fitted, [10.0 * fitted], np.array([0.1]), np.array([1.0]))
    # The mean of both motions' squares is 50.5; the error hides 0.1 of a parameter.
    assert reach.factor == pytest.approx([0.1 * np.sqrt(50.5)])
    assert find_reach(fitted, [], np.array([0.1]), np.array([1.0])).factor == pytest.approx([0.1])


def hardly_moving(rng):
    """Joint 2 moves a hundredth of what it does elsewhere."""
    fitted = planar_regressor(rng, SAMPLES)
    fitted[:, [1, 2, 3]] *= 0.01
    fitted[:, 7] *= 0.01
    return fitted


def test_prediction_uses_what_the_data_carry():
    rng = np.random.default_rng(7)
    fitted, other = hardly_moving(rng), planar_regressor(rng, SAMPLES)
    measured = fitted @ TRUTH + unlike(fitted, 1, 0.3) + 0.05 * rng.normal(size=len(fitted))
    torque = measured.reshape(-1, JOINTS)
    truth = other @ TRUTH
    usual = np.sqrt(np.mean(truth.reshape(-1, JOINTS) ** 2, axis=0))
    alone = identify(fitted, torque, NAMES, UNITS)
    carried = identify(fitted, torque, NAMES, UNITS, others=(other,), usual_torque=usual)
    assert (alone.reach <= LARGEST_REACH).all()
    assert (carried.reach > LARGEST_REACH).any()
    assert carried.status == "reduced"
    assert relative(carried.predict(other), truth) < 0.5 * relative(alone.predict(other), truth)


def test_what_is_left_out_is_named_and_not_quoted():
    rng = np.random.default_rng(8)
    fitted, other = hardly_moving(rng), planar_regressor(rng, SAMPLES)
    torque = (fitted @ TRUTH + unlike(fitted, 1, 0.3)).reshape(-1, JOINTS)
    usual = np.sqrt(np.mean((other @ TRUTH).reshape(-1, JOINTS) ** 2, axis=0))
    found = identify(fitted, torque, NAMES, UNITS, others=(other,), usual_torque=usual)
    assert {"mx_2", "Izz_2"} & set(found.unidentifiable)
    assert {"Fc_1", "Fv_1", "Izz_1"} <= set(found.names) - set(found.unidentifiable)
    reasons = dict(zip(found.unidentifiable, found.reasons, strict=True))
    assert any("hardly excited by the recordings for estimation" in r for r in reasons.values())
