import numpy as np
import pytest

from oed.diagnosis.data.band import Band, choose_band, position_noise


def test_decimating_filter_is_the_plain_convolution():
    band = Band(rate=1000.0, factor=13, cutoff=30.0, smoothing=90.0)
    x = np.random.default_rng(0).normal(size=(1000, 2))
    plain = np.stack([np.convolve(c, band.taps, "valid")[:: band.factor] for c in x.T], axis=1)
    assert np.allclose(band.apply(x), plain)
    assert len(band.instants(np.arange(1000.0))) == len(plain)


def test_filter_shifts_no_phase():
    band = Band(rate=1000.0, factor=10, cutoff=30.0, smoothing=90.0)
    t = np.arange(3000) / 1000
    slow = np.sin(2 * np.pi * 3 * t)
    assert np.allclose(band.apply(slow), np.sin(2 * np.pi * 3 * band.instants(t)), atol=0.01)


def test_finds_encoder_noise_and_where_motion_ends():
    rng = np.random.default_rng(1)
    t = np.arange(20000) / 1000
    q = np.stack([np.sin(2 * np.pi * 0.7 * t) + 1e-5 * rng.normal(size=len(t))], axis=1)
    noise = position_noise([q], 1000.0)
    assert noise.density[0] == pytest.approx(2 * 1e-10 / 1000, rel=0.15)
    assert 0.7 < noise.reach[0] <= noise.end[0] < 20


def test_an_acceleration_keeps_the_motion_and_little_of_the_noise():
    rng = np.random.default_rng(2)
    rate, turn = 250.0, 2 * np.pi * np.array([0.5, 5.0])
    t = np.arange(10000) / rate
    true = np.array([1.0, 0.01]) * np.sin(t[:, None] * turn)
    steps = np.array([1e-3, 1e-7])  # [rad] of a coarse encoder under a slow joint, and a fine one
    noisy = true + steps * rng.uniform(-0.5, 0.5, true.shape)
    band = choose_band(position_noise([noisy], rate), rate, lowest=8.0, highest=30.0)
    assert band.calming[0] < band.cutoff
    assert band.calming[1] == band.smoothing
    settled = slice(round(band.edge * rate), -round(band.edge * rate))
    _, dq, ddq = (x[settled] for x in band.differentiate(noisy))
    expected = band.apply((-(turn**2) * true)[settled])
    error = np.std(band.apply(ddq) - expected, axis=0) / np.std(expected, axis=0)
    # Central differences of differences take the sine of the step for the step, twice.
    assert error[1] < 2 * (turn[1] / rate) ** 2
    assert error[0] < 0.03
    plain = band.apply(np.gradient(dq[:, :1], 1 / rate, axis=0))
    assert np.std(plain - expected[:, :1]) > 5 * error[0] * np.std(expected[:, 0])
