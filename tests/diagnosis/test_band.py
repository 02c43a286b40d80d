import numpy as np
import pytest

from oed.diagnosis.data.band import Band, position_noise


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
    density, reach = position_noise([q], 1000.0)
    assert density[0] == pytest.approx(2 * 1e-10 / 1000, rel=0.15)
    assert 0.7 < reach[0] < 20
