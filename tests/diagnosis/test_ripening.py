"""A spring is judged on the torque that it leaves, not on that of an arm taken for rigid."""

import numpy as np
import pytest

from oed.diagnosis.baseline.baseline import find_baseline
from oed.diagnosis.data.prepare import prepare
from oed.diagnosis.search.ripening import ripened
from oed.diagnosis.search.scan import refine, scan
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.recording import Recording
from oed.robot import imi_scara
from tests.dynamics.effects.arms import smooth_motion
from tests.dynamics.effects.two_mass import two_mass_torque

SPRING = (6.0, 0.08, 0.15)  # Hz, damping, the rotor's share
COULOMB, VISCOUS, NOISE = np.array([2.6, 1.5]), np.array([7.3, 0.8]), np.array([0.1, 0.02])
PACE = 5.0  # times as fast: a spring shows in what accelerates


@pytest.fixture(scope="module")
def shop():
    robot, rng = imi_scara(), np.random.default_rng(3)
    slow = smooth_motion(robot, duration=20.0, step=1e-2)
    motion = Motion(slow.t / PACE, slow.q, PACE * slow.dq, PACE**2 * slow.ddq)
    torque = two_mass_torque(robot, motion, 0, SPRING)
    torque = torque + COULOMB * np.sign(motion.dq) + VISCOUS * motion.dq
    torque = torque + NOISE * rng.normal(size=torque.shape)
    measured = motion.q + 1e-6 * rng.normal(size=motion.q.shape)
    recording = Recording("estimation", "estimation", motion.t, measured, torque)
    settings = DiagnosisSettings()
    prepared = prepare((recording,), settings)
    baseline = find_baseline(TorqueModel.standard(robot), prepared)
    return Workshop(baseline, prepared, (), settings, gear_ratio=None)


def test_finds_the_spring_that_the_wrong_torque_hides(shop):
    fit = shop.fit(()).fit
    trials = [t for t in shop.physical if t.key == ("joint_elasticity", 0)]
    unripe = refine(scan(trials, fit, shop.context)[0], fit, shop.context)
    ripe = ripened(shop, trials, (), fit)
    assert ripe.gain > unripe.gain
    frequency, damping, rotor_share = ripe.trial.values
    assert frequency == pytest.approx(SPRING[0], rel=0.03)
    assert damping == pytest.approx(SPRING[1], rel=0.2)
    assert rotor_share == pytest.approx(SPRING[2], abs=0.05)
    # What the arm taken for rigid makes of the rotor is far off.
    assert abs(unripe.trial.values[2] - SPRING[2]) > 3 * abs(rotor_share - SPRING[2])
