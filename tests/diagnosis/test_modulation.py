"""What comes and goes with the state of the arm: found where it is, and not in noise of any colour."""

import numpy as np
import pytest

from oed.diagnosis.evidence.differing import Differing
from oed.diagnosis.evidence.modulation import find_modulations
from tests.diagnosis.noise import coloured

RATE = 40.0  # [Hz]
SAMPLES = 3200
PERIOD = 400  # samples


def _motion(rng):
    """Five harmonics of the period: position and its slope."""
    turn = 2 * np.pi * np.arange(SAMPLES)[:, None] / PERIOD
    order = np.arange(1, 6)[:, None, None]
    phase, size = rng.uniform(0, 2 * np.pi, (5, 1, 2)), rng.uniform(0.1, 0.4, (5, 1, 2))
    q = np.sum(size * np.sin(order * turn + phase), axis=0)
    return q, np.sum(size * order * np.cos(order * turn + phase), axis=0)


def _recording(torque, q, dq):
    laps = torque.reshape(-1, PERIOD, 2)
    between = (laps - laps.mean(axis=0)).reshape(torque.shape)
    return Differing(between, q, np.tanh(dq / 0.05), float(PERIOD))


@pytest.mark.parametrize("pole", [0.0, 0.9, 0.99])
def test_noise_is_not_modulated(pole):
    """Nor noise that is louder while the arm moves fast."""
    rng = np.random.default_rng(5)
    alarms = 0
    for draw in range(60):
        q, dq = _motion(rng)
        loud = 1 + (draw % 2) * np.abs(dq)
        recordings = [_recording(loud * coloured(rng, SAMPLES, pole), q, dq) for _ in range(2)]
        alarms += bool(find_modulations(recordings, RATE))
    # One in a hundred, of any colour.
    assert alarms <= 1


@pytest.mark.parametrize("pole", [0.0, 0.9])
def test_finds_a_brake_that_drags_now_and_then(pole):
    rng = np.random.default_rng(6)
    q, dq = _motion(rng)
    recordings = []
    for _ in range(2):
        drags = np.repeat(rng.random(SAMPLES // 160 + 1) < 0.4, 160)[:SAMPLES]
        torque = coloured(rng, SAMPLES, pole)
        torque[:, 1] += 3.0 * drags * np.tanh(dq[:, 1] / 0.05)
        recordings.append(_recording(torque, q, dq))
    (found,) = find_modulations(recordings, RATE)
    assert found.joint == 1
    assert found.depends_on == ("time", "dq_2")


def test_finds_a_field_that_turns():
    rng = np.random.default_rng(7)
    q, dq = _motion(rng)
    t = np.arange(SAMPLES) / RATE
    recordings = []
    for phase in (0.4, 2.9):
        torque = coloured(rng, SAMPLES, 0.8)
        torque[:, 0] += 2.0 * np.sin(2 * np.pi * 0.237 * t + phase) * np.cos(2 * q[:, 0])
        recordings.append(_recording(torque, q, dq))
    (found,) = find_modulations(recordings, RATE)
    assert found.joint == 0
    assert found.depends_on == ("time", "q_1")
    frequency = float(found.label.split("2 pi ")[1].split(" t")[0])
    assert frequency == pytest.approx(0.237, abs=RATE / SAMPLES)


def test_an_arm_at_rest_shows_nothing():
    still = np.zeros((SAMPLES, 2))
    assert find_modulations([Differing(still, still, still, float(PERIOD))], RATE) == ()
    assert find_modulations([], RATE) == ()
