import numpy as np
import pytest
from scipy.signal import firwin, lfilter

from oed.estimation.noise_floor.autoregression import fit_autoregression


def coloured(rng, count):
    return np.asarray(lfilter([1.0], [1.0, -1.4, 0.6], rng.normal(size=count + 200)))[200:]


def test_whitened_noise_is_white_and_of_unit_variance():
    rng = np.random.default_rng(0)
    noise = fit_autoregression([coloured(rng, 4000) for _ in range(3)])
    white = noise.whiten(coloured(rng, 20000))[noise.order :]
    assert np.var(white) == pytest.approx(1.0, abs=0.06)
    power = white @ white
    for lag in (1, 2, 5, 10):
        assert abs(white[lag:] @ white[:-lag] / power) < 0.05


def test_rows_that_are_not_noise_are_left_out():
    rng = np.random.default_rng(1)
    noise = coloured(rng, 6000)
    trusted = np.ones(6000, dtype=bool)
    for start in range(100, 6000, 300):
        noise[start : start + 10] += 50.0
        trusted[start : start + 10] = False
    found = fit_autoregression([noise], trusted=[trusted])
    assert found.scale == pytest.approx(1.0, rel=0.15)


def test_gaps_that_leave_few_rows_a_past_do_not_make_the_noise_louder():
    """A narrow band, as filtered torque is, and a joint that stops every other second."""
    rng = np.random.default_rng(4)
    taps = firwin(25, 0.8)
    noise = [np.asarray(lfilter(taps, [1.0], rng.normal(size=230)))[50:] for _ in range(8)]
    trusted = np.arange(180) % 30 < 16
    loud = [np.where(trusted, x, 5 * x) for x in noise]
    found, whole = fit_autoregression(loud, trusted=[trusted] * 8), fit_autoregression(noise)
    # Where gaps are taken for noise, or crossed as if nothing were missing, it is 1.4 times this.
    assert found.scale == pytest.approx(whole.scale, rel=0.2)


def test_scale_is_the_most_likely_one_of_the_rows_that_are_trusted():
    """Of the autoregression itself, every other row of it missing: nothing is left of its past."""
    noise = [coloured(np.random.default_rng(k), 600) for k in range(6)]
    trusted = np.arange(600) % 4 < 2
    scale = fit_autoregression(noise, trusted=[trusted] * 6).scale
    assert scale == pytest.approx(fit_autoregression(noise).scale, rel=0.1)


def gain(noise, frequency):
    """Of whitening, at shares of the Nyquist frequency."""
    lags = np.arange(noise.order + 1)
    return np.abs(np.exp(-1j * np.pi * np.outer(frequency, lags)) @ noise.coefficients)


def test_whitening_does_not_undo_a_low_pass():
    """Where a filter has left next to nothing, errors of a model would be raised to the size of noise."""
    rng = np.random.default_rng(5)
    taps = firwin(25, 0.6)  # half is left at the edge
    noise = [np.asarray(lfilter(taps, [1.0], rng.normal(size=3000)))[50:] for _ in range(4)]
    held, undone = (fit_autoregression(noise, edge=edge) for edge in (0.6, 1.0))
    beyond = np.linspace(0.7, 1.0, 31)
    assert gain(undone, beyond).max() > 8 * gain(undone, np.array([0.1]))[0]
    assert gain(held, beyond).max() < 3 * gain(held, np.array([0.1]))[0]
    # Within the band rows are as white, and as large, as before.
    inside = np.linspace(0.02, 0.4, 20)
    assert gain(held, inside) / held.scale == pytest.approx(1.0, rel=0.25)
    assert gain(undone, inside) / undone.scale == pytest.approx(1.0, rel=0.25)


def test_filter_is_the_same_for_columns_and_torque():
    rng = np.random.default_rng(2)
    noise = fit_autoregression([coloured(rng, 3000)])
    columns = rng.normal(size=(500, 3))
    parameters = np.array([1.0, -2.0, 0.5])
    assert np.allclose(noise.whiten(columns) @ parameters, noise.whiten(columns @ parameters))
