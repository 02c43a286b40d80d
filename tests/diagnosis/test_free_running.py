"""Lines that keep their own time: found where they are, and not in noise of any colour."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.evidence.differing import Differing
from oed.diagnosis.evidence.free_running import find_lines
from tests.diagnosis.noise import coloured

RATE = 40.0  # [Hz]
SAMPLES = 1200
PERIOD = 400  # samples


def _between(x, period):
    """Less the mean over its repetitions."""
    laps = x.reshape(-1, period, x.shape[1])
    return (laps - laps.mean(axis=0)).reshape(x.shape)


def _lines(stretches, period):
    recordings = [Differing(_between(x, period), x, x, float(period)) for x in stretches]
    return find_lines(recordings, RATE, 16.0)


@pytest.mark.parametrize("repetitions", [2, 3, 6])
@pytest.mark.parametrize("pole", [0.0, 0.8, 0.98])
def test_noise_has_no_line(pole, repetitions):
    """Nor where few repetitions differ only at frequencies between the motion's own."""
    rng = np.random.default_rng(3)
    draws, period = 400, SAMPLES // repetitions
    alarms = sum(
        bool(_lines([coloured(rng, SAMPLES, pole), coloured(rng, SAMPLES, pole)], period))
        for _ in range(draws)
    )
    # One in a hundred, of any colour.
    assert alarms <= 4


def test_noise_that_grows_towards_slow_has_no_line_of_a_few_cycles():
    """Sensors flicker: power goes with one over the frequency."""
    rng = np.random.default_rng(5)
    frequency = np.fft.rfftfreq(SAMPLES, 1 / RATE)
    slope = (1 + frequency / 0.05) ** -0.6

    def flicker():
        return np.fft.irfft(
            slope[:, None] * np.fft.rfft(rng.normal(size=(SAMPLES, 2)), axis=0), axis=0
        )

    short = 600  # samples: a line of 0.37 Hz has 5 to 6 cycles
    alarms = sum(bool(_lines([flicker()[:short], flicker()[:short]], 100)) for _ in range(400))
    assert alarms <= 4


@pytest.mark.parametrize("pole", [0.0, 0.8])
def test_finds_a_line_of_a_third_of_the_noise(pole):
    rng = np.random.default_rng(4)
    t = np.arange(SAMPLES) / RATE
    stretches = []
    for phase in (0.3, 2.0):
        x = coloured(rng, SAMPLES, pole)
        x[:, 1] += 0.47 * np.sin(2 * np.pi * 3.25 * t + phase)
        stretches.append(x)
    (line,) = _lines(stretches, PERIOD)
    assert line.joint == 1
    assert line.frequency == pytest.approx(3.25, abs=0.5 * RATE / SAMPLES)
    assert line.amplitude == pytest.approx(0.47, abs=0.1)
    assert line.share == pytest.approx(0.1, abs=0.04)


def _single(rng, hum):
    """Two motions without repetitions, a part of whose torque the model leaves; and a hum."""
    t, recordings = np.arange(SAMPLES) / RATE, []
    for _ in range(2):
        orders, phases = np.arange(1, 8), rng.uniform(0, 2 * np.pi, 7)
        waves = np.sin(2 * np.pi * np.outer(t, orders) / (PERIOD / RATE) + phases)
        predicted = np.stack([waves.sum(axis=1), waves.sum(axis=1)], axis=1)
        left = coloured(rng, SAMPLES, 0.8)
        left[:, 0] += 0.3 * waves[:, 4]
        left[:, 1] += hum * np.sin(2 * np.pi * 3.25 * t + rng.uniform(0, 6))
        recordings.append(Differing(left, waves[:, :2], waves[:, :2], np.inf, predicted))
    return find_lines(recordings, RATE, 16.0)


def test_where_nothing_is_repeated_a_line_that_the_motion_has_is_none():
    rng = np.random.default_rng(5)
    assert not any(_single(rng, hum=0.0) for _ in range(100))
    (line,) = _single(rng, hum=1.5)
    assert line.joint == 1
    assert line.frequency == pytest.approx(3.25, abs=0.5 * RATE / SAMPLES)
    assert line.amplitude == pytest.approx(1.5, abs=0.2)


def test_where_nothing_is_repeated_a_line_is_larger_than_what_the_motion_does_there():
    """A motion of many frequencies, none of which stands out, of which the model misses one."""
    rng = np.random.default_rng(6)
    t, recordings = np.arange(SAMPLES) / RATE, []
    orders = np.arange(3, 241)
    for _ in range(2):
        waves = np.sin(2 * np.pi * np.outer(t, orders) * RATE / SAMPLES + rng.uniform(0, 6, 238))
        predicted = 20.0 * np.tile(waves.sum(axis=1)[:, None], 2)
        left = coloured(rng, SAMPLES, 0.8)
        left[:, 1] += 1.5 * np.sin(2 * np.pi * 3.25 * t)
        recordings.append(Differing(left, predicted, predicted, np.inf, predicted))
    assert find_lines(recordings, RATE, 16.0) == ()
    small = [dataclasses.replace(r, predicted=r.predicted / 400) for r in recordings]
    assert [line.joint for line in find_lines(small, RATE, 16.0)] == [1]


def test_nothing_to_look_at():
    still = np.zeros((SAMPLES, 2))
    assert find_lines([], RATE, 16.0) == ()
    assert find_lines([Differing(still, still, still, float(PERIOD))], RATE, 0.1) == ()
