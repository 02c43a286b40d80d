"""Friction brakes: torques under which it drives every joint have the wrong sign."""

import numpy as np
import pytest

from oed.errors import OedError
from oed.estimation.dissipation import check_dissipation, driven_joints

DQ = np.stack([np.sin(np.linspace(0, 20, 500)), np.cos(np.linspace(0, 30, 500))], axis=1)
FRICTION = {"Fc_1": 0.4, "Fv_1": 0.1, "Fc_2": 0.3, "Fv_2": -0.05}
TORQUE = 5.0 * DQ


def _reversed(friction, *joints):
    return {name: -f if int(name[-1]) in joints else f for name, f in friction.items()}


def test_friction_that_brakes_passes():
    check_dissipation(FRICTION, DQ, TORQUE, "arm")


def test_torques_of_the_opposite_sign_are_refused():
    with pytest.raises(OedError, match=r"arm: .*signs of the tau columns"):
        check_dissipation(_reversed(FRICTION, 1, 2), DQ, -TORQUE, "arm")


def test_one_joint_alone_is_no_evidence():
    check_dissipation(_reversed(FRICTION, 1), DQ, TORQUE, "arm")


def test_no_friction_behind_a_sensor_has_either_sign():
    check_dissipation({"Fc_1": -1e-3, "Fc_2": -2e-3}, DQ, TORQUE, "arm")
    check_dissipation({}, DQ, TORQUE, "arm")


def test_the_joint_that_friction_drives_is_told():
    assert driven_joints(FRICTION, DQ, TORQUE) == []
    assert driven_joints(_reversed(FRICTION, 2), DQ, TORQUE) == [1]
    assert driven_joints({"Fc_1": -1e-3, "Fc_2": -2e-3}, DQ, TORQUE) == []
    assert driven_joints(FRICTION, DQ, 0 * TORQUE) == []
