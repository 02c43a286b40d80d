"""What no name of the catalogue fits is found by what it depends on."""

import numpy as np

from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set

SETTINGS = DiagnosisSettings(surrogates=39, bootstrap=40, refined=4)


def test_a_drag_on_another_joints_speed_is_no_motor_and_depends_on_nothing_else():
    def drag(q, dq, ddq):
        return np.stack([0.15 * dq[:, 1], np.zeros(len(q))], axis=1)

    dataset = data_set(4, extra=drag)
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), SETTINGS)
    assert not found.effects
    assert [(u.joint, u.depends_on) for u in found.unexplained] == [(0, ("dq_2",))]


def test_friction_that_acceleration_changes_is_found_by_it_and_has_no_name():
    def hasty(q, dq, ddq):
        return 0.5 * np.tanh(np.abs(ddq) / 4.0) * np.sign(dq) * [0, 1]

    dataset = data_set(4, extra=hasty)
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), SETTINGS)
    assert not found.effects
    assert [(u.joint, set(u.depends_on)) for u in found.unexplained] == [(1, {"ddq_2", "dq_2"})]
    test = next(p for p in found.proof if p.role == "test")
    assert (test.after / found.noise_floor).max() < 1.1 < (test.before / found.noise_floor).max()
