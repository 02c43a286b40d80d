"""A swing or a push that no motion has is told, and noise or misfit of a motion never is."""

import numpy as np
import pytest

from oed.diagnosis.diagnose import diagnose
from oed.diagnosis.inference.disturbances import burst, swing
from oed.dynamics.torque_model import TorqueModel
from oed.report.next_steps import _disturbed
from tests.diagnosis.arm import NOISE, data_set

RATE = 100.0  # [Hz]


def test_a_swing_is_told_by_its_frequency_and_its_size():
    rng = np.random.default_rng(0)
    t = np.arange(2000) / RATE
    slow = 30.0 * np.sin(2 * np.pi * 0.5 * t)
    found = swing(2.0 * np.sin(2 * np.pi * 3.31 * t) + rng.normal(size=len(t)), slow, RATE)
    assert found is not None
    frequency, rms, share = found
    assert frequency == pytest.approx(3.31, abs=0.01)
    assert rms == pytest.approx(np.sqrt(2.0), rel=0.1)
    assert share == pytest.approx(2 / 3, abs=0.05)  # 2 of 2 + 1


def test_a_line_that_the_motion_has_may_be_its_misfit():
    t = np.arange(2000) / RATE
    left = np.sin(2 * np.pi * 0.5 * t)
    assert swing(left, 0.5 * left, RATE) is not None
    assert swing(left, 2.0 * left, RATE) is None


def test_a_push_is_told_by_its_recording_and_its_moment():
    rng = np.random.default_rng(2)
    left = [rng.normal(size=2000) for _ in range(3)]
    left[1][700:800] += 15.0
    found = burst(left, RATE)
    assert found is not None
    recording, start, end, rms, share = found
    assert recording == 1
    assert (start, end) == (7.0, 8.0)
    assert rms == pytest.approx(np.sqrt(15.0**2 + 1), rel=0.05)
    assert share == pytest.approx(100 * 226 / (100 * 226 + 5900), rel=0.05)


def test_noise_of_any_colour_and_a_drift_are_neither():
    rng = np.random.default_rng(1)
    for _ in range(200):
        white = rng.normal(size=1000)
        assert swing(white, 0 * white, RATE) is None
        assert swing(np.cumsum(white), 0 * white, RATE) is None
        assert burst([white], RATE) is None


@pytest.mark.parametrize("repetitions", [1, 3])
def test_a_diagnosis_says_where_something_swings(repetitions):
    def hum(t, dq):
        return np.outer(np.sin(2 * np.pi * 3.37 * t), [0.0, 6 * NOISE[1]])

    dataset = data_set(51, hum=hum, repetitions=repetitions)
    found = diagnose(dataset, TorqueModel.standard(dataset.robot), names=("torque_offset",))
    (disturbance,) = found.disturbances
    assert disturbance.joint == 1
    assert disturbance.rms == pytest.approx(6 * NOISE[1] / np.sqrt(2), rel=0.1)
    assert "3.37 Hz" in disturbance.words
    assert found.verdict == "unexplained"
    assert any(u.joint == 1 and u.label == disturbance.words for u in found.unexplained)
    (step,) = _disturbed(found)
    assert "joint 2" in step.text
    assert "stands still" in step.text
