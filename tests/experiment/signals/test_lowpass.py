"""The zero-phase filter against sinusoids."""

import numpy as np
import pytest

from oed.experiment.signals.lowpass import half_power_frequency, lowpass

RATE = 1000.0
T = np.arange(8000) / RATE
MIDDLE = slice(2000, 6000)  # 4 s: whole periods of every frequency below


def gain_and_phase(frequency: float, cutoff: float, order: int) -> tuple[float, float]:
    filtered = lowpass(np.sin(2 * np.pi * frequency * T), RATE, cutoff, order)[MIDDLE]
    wave = np.exp(-2j * np.pi * frequency * T[MIDDLE])
    response = 2j * np.mean(filtered * wave)
    return float(abs(response)), float(np.angle(response))


@pytest.mark.parametrize("order", [2, 4])
@pytest.mark.parametrize("frequency", [1.0, 5.0, 8.0, 10.0, 12.0, 20.0])
def test_gain_is_that_of_two_passes_and_phase_is_zero(frequency, order):
    gain, phase = gain_and_phase(frequency, 10.0, order)
    # The bilinear transform maps f to tan(pi f / rate).
    ratio = np.tan(np.pi * frequency / RATE) / np.tan(np.pi * 10.0 / RATE)
    assert gain == pytest.approx(1 / (1 + ratio ** (2 * order)), abs=1e-6)
    assert phase == pytest.approx(0, abs=1e-6)


def test_cutoff_is_where_the_amplitude_halves():
    assert gain_and_phase(10.0, 10.0, 4)[0] == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_half_power_frequency(order):
    cutoff = 8.0 / half_power_frequency(1.0, order)
    assert gain_and_phase(8.0, cutoff, order)[0] == pytest.approx(np.sqrt(0.5), abs=1e-3)


def test_a_straight_line_passes_unchanged():
    line = np.stack([3 + 2 * T, -T], axis=1)
    error = np.abs(lowpass(line, RATE, 10.0) - line)
    assert error[MIDDLE].max() < 1e-11
    # A pass starts as if the first value had stood for ever, so it is wrong by the slope times
    # the filter's delay; the slowest pole pair (damping sin(pi/8)) has three periods to forget.
    delay = 2 * (np.sin(np.pi / 8) + np.sin(3 * np.pi / 8)) / (2 * np.pi * 10.0)
    assert error.max() < 2 * delay * np.exp(-np.sin(np.pi / 8) * 2 * np.pi * 3)


def test_does_not_write_into_its_argument():
    x = np.sin(T)
    lowpass(x, RATE, 10.0)
    assert np.array_equal(x, np.sin(T))


@pytest.mark.parametrize(("cutoff", "order"), [(0.0, 4), (500.0, 4), (-1.0, 4), (10.0, 0)])
def test_refuses_a_filter_that_does_not_exist(cutoff, order):
    with pytest.raises(ValueError, match=r"must"):
        lowpass(T, RATE, cutoff, order)
