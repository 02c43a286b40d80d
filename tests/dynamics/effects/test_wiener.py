"""Torque worked out from a noisy motion: what is expected of it, and a gear that it drives."""

import dataclasses

import numpy as np
import pytest
from scipy.signal import firwin, lfilter

from oed.dynamics.effects.effect import State
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.effects.transmission import JointElasticity
from oed.dynamics.effects.wiener import expected
from tests.dynamics.effects.arms import smooth_motion, vertical_arm

RATE, SAMPLES = 200.0, 12_000
STEP = 1e-3  # [s]
DENSITY = 1e-13  # [rad^2/Hz] of encoder noise, one-sided


def _white(seed: int, density: float, count: int, rate: float) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=count) * np.sqrt(density * rate / 2)


def _twice_differentiated(noise: np.ndarray, rate: float) -> np.ndarray:
    frequency = np.fft.rfftfreq(len(noise), 1 / rate)
    return np.fft.irfft(-((2 * np.pi * frequency) ** 2) * np.fft.rfft(noise), len(noise))


def test_noise_alone_is_not_expected() -> None:
    noise = _twice_differentiated(_white(0, DENSITY, SAMPLES, RATE), RATE)
    (kept,) = expected([noise], RATE, DENSITY)
    # Spectra of some 30 stretches scatter by a few hundredths: what they have too much is kept.
    assert np.std(kept) < 0.06 * np.std(noise)


def test_what_stands_out_is_kept_as_it_is() -> None:
    t = np.arange(SAMPLES) / RATE
    slow = 3.0 * np.sin(2 * np.pi * 0.3 * t) + np.sin(2 * np.pi * 1.1 * t + 1)
    (kept,) = expected([slow], RATE, DENSITY)
    inner = slice(100, -100)  # an end, mirrored, has a kink in its slope's slope
    assert kept[inner] == pytest.approx(slow[inner], abs=0.01)


@pytest.mark.parametrize(("highest", "size"), [(6.0, 0.05), (20.0, 1.0), (20.0, 10.0)])
def test_error_is_that_of_the_best_filter_there_is(highest: float, size: float) -> None:
    """Against the filter of the true spectra (Wiener 1949)."""
    noise = _twice_differentiated(_white(1, DENSITY, SAMPLES, RATE), RATE)
    shape = firwin(401, highest, fs=RATE)
    filtered = lfilter(shape, 1.0, np.random.default_rng(2).normal(size=SAMPLES))
    signal = size * np.asarray(filtered)
    (kept,) = expected([signal + noise], RATE, DENSITY)
    frequency = np.fft.rfftfreq(8 * SAMPLES, 1 / RATE)
    power = size**2 * np.abs(np.fft.rfft(shape, 8 * SAMPLES)) ** 2 * 2 / RATE
    heard = DENSITY * (2 * np.pi * frequency) ** 4
    least = np.sqrt(np.trapezoid(power * heard / np.maximum(power + heard, 1e-300), frequency))
    # Spectra that must be read off the data cost some hundredths of the noise.
    inner = slice(200, -200)
    error = np.std((kept - signal)[inner])
    assert least < error < np.hypot(1.2 * least, 0.045 * np.std(noise))


def test_signals_of_one_motion_keep_the_same_share() -> None:
    noise = _twice_differentiated(_white(3, DENSITY, SAMPLES, RATE), RATE)
    wave = np.sin(2 * np.pi * 0.5 * np.arange(SAMPLES) / RATE)
    first, second = expected([wave + noise, 0.3 * (wave + noise)], RATE, DENSITY)
    assert second == pytest.approx(0.3 * first, abs=1e-9)


def test_a_gear_does_not_ring_with_the_noise_of_its_encoder() -> None:
    robot = vertical_arm()
    clean = smooth_motion(robot, duration=20.0, step=STEP)
    noise = np.stack([_white(k, DENSITY, len(clean), 1 / STEP) for k in range(2)], axis=1)
    # As a logger's smoothing leaves them: 24 Hz and less.
    frequency = np.fft.rfftfreq(len(clean), STEP)[:, None]
    spectrum = np.fft.rfft(noise, axis=0) * (frequency < 24.0)
    orders = ((2j * np.pi * frequency) ** k * spectrum for k in range(3))
    q, dq, ddq = (np.fft.irfft(x, len(clean), axis=0) for x in orders)
    measured = dataclasses.replace(clean, q=clean.q + q, dq=clean.dq + dq, ddq=clean.ddq + ddq)
    aware = dataclasses.replace(measured, noise=(DENSITY, DENSITY))
    gear = JointElasticity(0, 6.0, 0.05, 0.2, 0.0, 0.0, (0.0, 0.0), ReferenceTorque(robot))
    known = dataclasses.replace(clean, noise=(DENSITY, DENSITY))
    motions = (clean, measured, aware, known)
    true, *others = (gear.bend(State.along(m)).ddd for m in motions)
    inner = slice(2000, -2000)
    deaf, heard, exact = (np.std((x - true)[inner]) / np.std(true[inner]) for x in others)
    assert deaf > 2
    assert heard < 0.15
    # A motion that stands out is followed as it is.
    assert exact < 0.005
