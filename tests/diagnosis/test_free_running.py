"""Lines that keep their own time: found where they are, and not in noise of any colour."""

import numpy as np
import pytest
from scipy.signal import lfilter

from oed.diagnosis.evidence.free_running import LEVEL, find_lines

RATE = 40.0  # [Hz]
SAMPLES = 1200


def _noise(rng, pole):
    white = rng.normal(size=(SAMPLES + 500, 2))
    return np.asarray(lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], white, axis=0))[500:]


@pytest.mark.parametrize("pole", [0.0, 0.8, 0.98])
def test_noise_has_no_line(pole):
    rng = np.random.default_rng(3)
    draws = 400
    alarms = sum(
        bool(find_lines([_noise(rng, pole), _noise(rng, pole)], RATE, 16.0)) for _ in range(draws)
    )
    # At the nominal level 0.4 of 400 are expected; more than 4 has a chance below 1e-4.
    assert LEVEL * draws == pytest.approx(0.4)
    assert alarms <= 4


@pytest.mark.parametrize("pole", [0.0, 0.8])
def test_finds_a_line_of_a_third_of_the_noise(pole):
    rng = np.random.default_rng(4)
    t = np.arange(SAMPLES) / RATE
    stretches = []
    for phase in (0.3, 2.0):
        x = _noise(rng, pole)
        x[:, 1] += 0.47 * np.sin(2 * np.pi * 3.21 * t + phase)
        stretches.append(x)
    (line,) = find_lines(stretches, RATE, 16.0)
    assert line.joint == 1
    assert line.frequency == pytest.approx(3.21, abs=0.5 * RATE / SAMPLES)
    assert line.amplitude == pytest.approx(0.47, abs=0.1)
    assert line.share == pytest.approx(0.1, abs=0.04)


def test_nothing_to_look_at():
    assert find_lines([], RATE, 16.0) == ()
    assert find_lines([np.zeros((SAMPLES, 2))], RATE, 0.1) == ()
