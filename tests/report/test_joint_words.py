"""What joints and their units are called."""

import dataclasses

from oed.report.joint_words import torque_label
from oed.robot import imi_scara


def test_a_force_is_not_called_a_torque() -> None:
    turning, _ = imi_scara().joints
    sliding = dataclasses.replace(turning, kind="prismatic")
    assert torque_label([turning]) == "torque [N m]"
    assert torque_label([sliding], "residual torque") == "residual force [N]"
    assert torque_label([turning, sliding]) == "torque [N m; N at prismatic joints]"
