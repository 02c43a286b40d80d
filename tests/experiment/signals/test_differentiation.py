"""Derivatives against those of sinusoids and polynomials."""

import numpy as np
import pytest

from oed.experiment.signals.differentiation import (
    central_difference,
    spectral_derivative,
    spline_derivative,
)

RATE = 100.0


def test_central_difference_is_exact_for_parabolas_to_the_ends():
    t = np.arange(20) / RATE
    x = np.stack([t**2, 3 - t], axis=1)
    expected = np.stack([2 * t, -np.ones(20)], axis=1)
    assert np.allclose(central_difference(x, RATE), expected, rtol=0, atol=1e-11)


def test_central_difference_has_the_gain_stated():
    t, w = np.arange(200) / RATE, 2 * np.pi * 5
    gain = np.sin(w / RATE) / (w / RATE)
    derivative = central_difference(np.sin(w * t), RATE)[1:-1]
    assert np.allclose(derivative, gain * w * np.cos(w * t)[1:-1], rtol=0, atol=1e-10)


@pytest.mark.parametrize("order", [1, 2])
def test_spline_derivative_is_exact_for_polynomials_to_the_ends(order):
    t = np.arange(20) / RATE
    polynomial = np.polynomial.Polynomial(np.random.default_rng(0).normal(size=8))
    derivative = spline_derivative(polynomial(t / t[-1]), RATE, order)
    expected = polynomial.deriv(order)(t / t[-1]) / t[-1] ** order
    assert np.allclose(derivative, expected, rtol=0, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize(("order", "error"), [(1, 1e-4), (2, 3e-4)])
def test_spline_derivative_is_true_up_to_a_fifth_of_the_rate(order, error):
    t = np.arange(400) / RATE
    for frequency in (1.0, 5.0, 10.0, 20.0):
        turn = 2j * np.pi * frequency
        x = np.exp(turn * t)
        parts = np.stack([x.real, x.imag], axis=1)
        derivative = spline_derivative(parts, RATE, order)[50:-50]
        expected = (turn**order * x)[50:-50]
        expected = np.stack([expected.real, expected.imag], axis=1)
        assert np.abs(derivative - expected).max() < error * abs(turn) ** order


def test_spline_derivative_says_what_it_cannot_do():
    with pytest.raises(ValueError, match="at least 8"):
        spline_derivative(np.zeros(7), RATE)
    with pytest.raises(ValueError, match="positive"):
        spline_derivative(np.zeros(20), 0.0)
    with pytest.raises(ValueError, match="order 7"):
        spline_derivative(np.zeros(20), RATE, 7)


@pytest.mark.parametrize("samples", [200, 201])
@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_spectral_derivative_is_exact_for_a_band_limited_periodic_signal(samples, order):
    rng = np.random.default_rng(0)
    t = np.arange(samples) / RATE
    w = 2 * np.pi * RATE / samples
    coefficients = rng.normal(size=(5, 2)) @ np.array([1, 1j])
    waves = np.exp(1j * w * np.outer(t, np.arange(1, 6)))
    x = np.real(waves @ coefficients)
    expected = np.real(waves @ (coefficients * (1j * w * np.arange(1, 6)) ** order))
    derivative = spectral_derivative(x, RATE, harmonics=5, order=order)
    assert np.allclose(derivative, expected, rtol=0, atol=1e-10 * np.abs(expected).max())


def test_spectral_derivative_keeps_only_what_repeats():
    t = np.arange(400) / RATE  # four periods of 1 s
    periodic = np.cos(2 * np.pi * 3 * t)
    stray = np.cos(2 * np.pi * 1.25 * t)
    derivative = spectral_derivative(periodic + stray, RATE, repetitions=4)
    expected = -6 * np.pi * np.sin(2 * np.pi * 3 * t)
    assert np.allclose(derivative, expected, rtol=0, atol=1e-10)


def test_harmonics_above_the_last_kept_are_removed():
    t = np.arange(100) / RATE
    x = 2 + np.cos(2 * np.pi * 2 * t) + np.cos(2 * np.pi * 7 * t)
    kept = spectral_derivative(x, RATE, harmonics=4, order=0)
    assert np.allclose(kept, 2 + np.cos(2 * np.pi * 2 * t), rtol=0, atol=1e-12)


def test_refuses_what_is_no_whole_number_of_periods():
    with pytest.raises(ValueError, match="do not divide"):
        spectral_derivative(np.zeros(10), RATE, repetitions=3)
    with pytest.raises(ValueError, match="carry 4"):
        spectral_derivative(np.zeros(10), RATE, harmonics=5)
