"""The energy form estimates the parameters of the torque form."""

import numpy as np
import pytest

from oed.dynamics.effects import MeasurementEffect
from oed.dynamics.energy_model import EnergyModel
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import imi_scara


def _harmonic_motion(samples: int) -> Motion:
    t = np.linspace(0.0, 10.0, samples)
    a = np.array([[0.9, 0.3], [0.7, 0.5]])
    w = np.array([[1.3, 3.1], [1.9, 4.7]])
    phase = t[:, None, None] * w + np.array([[0.1, 1.0], [2.0, 0.4]])
    return Motion(
        t,
        (a * np.sin(phase)).sum(2),
        (a * w * np.cos(phase)).sum(2),
        (-a * w**2 * np.sin(phase)).sum(2),
    )


def test_work_is_the_regressor_times_the_same_parameters() -> None:
    model = TorqueModel.standard(imi_scara())
    motion = _harmonic_motion(20_001)
    truth = np.concatenate([model.robot.parameters, [2.6, 7.3, 1.5, 0.8]])
    energy = EnergyModel(model, window=250)
    work = energy.target(motion, model.torque(truth, motion))
    # Coulomb torque jumps where the velocity turns: Simpson's rule errs there by about
    # 2 Fc dq h, and the velocity within half a step of a turn is about 1e-3 rad/s.
    assert energy.regressor(motion) @ truth == pytest.approx(work, abs=1e-5)


def test_base_parameters_are_recovered_without_acceleration() -> None:
    model = TorqueModel.standard(imi_scara())
    base = base_parameters(model)
    motion = _harmonic_motion(20_001)
    truth = np.concatenate([model.robot.parameters, [2.6, 7.3, 1.5, 0.8]])
    energy = EnergyModel(model, window=250)
    blind = Motion(motion.t, motion.q, motion.dq, np.full_like(motion.ddq, np.nan))
    regressor = base.reduce(energy.regressor(blind))
    work = energy.target(motion, model.torque(truth, motion))
    estimate = np.linalg.lstsq(regressor, work, rcond=None)[0]
    assert estimate == pytest.approx(base.from_standard(truth), rel=1e-3)


def test_a_model_seen_through_measurement_has_no_energy_form() -> None:
    class Delay(MeasurementEffect):
        name = "delay"

        def through(self, columns, motion, rigid):
            return columns(motion)

    seen = TorqueModel.standard(imi_scara()).with_measurement(Delay())
    with pytest.raises(ValueError, match="no energy form"):
        EnergyModel(seen, window=10)
