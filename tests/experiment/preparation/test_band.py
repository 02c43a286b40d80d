import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects import State
from oed.dynamics.effects.deflection import deflect
from oed.dynamics.motion import Motion
from oed.experiment.preparation.band import Band, choose_band, position_noise


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
    assert band.acceleration_cutoffs[0] < band.cutoff
    assert band.acceleration_cutoffs[1] == band.smoothing
    settled = slice(round(band.edge * rate), -round(band.edge * rate))
    _, dq, ddq = (x[settled] for x in band.differentiate(noisy))
    expected = band.apply((-(turn**2) * true)[settled])
    error = np.std(band.apply(ddq) - expected, axis=0) / np.std(expected, axis=0)
    # Central differences of differences take the sine of the step for the step, twice.
    assert error[1] < 2 * (turn[1] / rate) ** 2
    assert error[0] < 0.03
    plain = band.apply(np.gradient(dq[:, :1], 1 / rate, axis=0))
    assert np.std(plain - expected[:, :1]) > 5 * error[0] * np.std(expected[:, 0])


@pytest.mark.parametrize(
    ("band", "fastest", "rate"),
    [
        (Band(rate=1000.0, factor=50, cutoff=8.0, smoothing=24.0), 60.0, 200.0),
        (Band(rate=1000.0, factor=50, cutoff=8.0, smoothing=24.0), 300.0, 500.0),
        (Band(rate=1000.0, factor=39, cutoff=10.0, smoothing=30.0), 60.0, 1000 / 3),
        (Band(rate=500.0, factor=25, cutoff=8.0, smoothing=24.0), 60.0, 500.0),
        (Band(rate=1000.0, factor=19, cutoff=20.1, smoothing=60.0), 60.0, 500.0),
        (Band(rate=999.0, factor=19, cutoff=20.1, smoothing=60.0), 60.0, 499.5),
        (Band(rate=1000.0, factor=50, cutoff=8.0, smoothing=24.0), 489.0, 1000.0),
        (Band(rate=1000.0, factor=13, cutoff=30.0, smoothing=90.0), 60.0, 1000.0),
        (Band(rate=100.0, factor=5, cutoff=8.0, smoothing=24.0), 60.0, 100.0),
    ],
)
def test_the_fine_grid_is_no_finer_than_the_band_and_its_waves_ask_for(band, fastest, rate):
    thinned = band.thinned(fastest)
    assert thinned.rate == pytest.approx(rate)
    assert (thinned.cutoff, thinned.smoothing) == (band.cutoff, band.smoothing)
    # A row lies a whole number of fine samples after another: a little nearer than before at most.
    assert 0.85 * band.factor < thinned.factor * thinned.logged <= band.factor


def test_what_is_seen_in_the_band_does_not_hang_on_the_fine_grid():
    """Friction's steps, a short wave of position and a swinging spring, at 1 kHz and thinned."""
    band = Band(rate=1000.0, factor=50, cutoff=8.0, smoothing=24.0)
    thinned = band.thinned(130 * 2.0 / (2 * np.pi))
    assert thinned.rate < band.rate / 2
    seen = [_effects_seen_in(dataclasses.replace(b, factor=1)) for b in (band, thinned)]
    for name, dense, coarse in zip(("friction", "wave", "spring"), *seen, strict=True):
        other = dense[:: thinned.logged][: len(coarse)]
        assert np.std(coarse[: len(other)] - other) < 0.01 * np.std(other), name


def _effects_seen_in(band):
    """Coulomb friction, a wave of 130 periods a turn and a mass on a spring, low-passed."""
    t = np.arange(round(20 * band.rate)) / band.rate
    q, dq = np.sin(2 * t), 2 * np.cos(2 * t)
    ddq = -4 * q
    columns = np.stack([q, dq, ddq], axis=1)
    motion = Motion(t, *(columns[:, [k]] for k in range(3)), averaged=True)
    state = State.along(motion)
    friction = np.asarray(state.sign(state.dq[0], 0.0))
    wave = np.cos(130 * q)
    brake = (dq, 0.0, 1.0, 0.0)
    spring = deflect(t, 5.0 * ddq + friction, 1.0 + 0 * t, (400.0, 4.0, 0.0, 0.0), brake)[0]
    start = round(1.2 * band.rate) - band.reach  # an instant of every grid that is tried
    return [band.apply(x[start:, None])[:, 0] for x in (friction, wave, spring)]


def test_a_coarser_grid_keeps_repetitions_in_phase():
    band = Band(rate=1000.0, factor=50, cutoff=8.0, smoothing=24.0)
    assert band.thinned(60.0, [10.0, 7.0]).rate == 200.0
    assert band.thinned(60.0, [10.002]).rate == 500.0
    assert band.thinned(60.0, [10.0005]) == band


def test_positions_are_smoothed_where_they_were_logged():
    """Rounding is white there alone: thinned first, it would be several times as large in the band."""
    rng = np.random.default_rng(4)
    band = Band(rate=1000.0, factor=50, cutoff=8.0, smoothing=24.0)
    thinned = band.thinned(60.0)
    q = rng.uniform(-0.5, 0.5, (60001, 1))
    for whole, coarse in zip(band.differentiate(q), thinned.differentiate(q), strict=True):
        assert np.array_equal(coarse, whole[:: thinned.logged])
    dense = thinned.as_logged(thinned.differentiate(q)[0])
    assert len(dense) == len(q)
    error = dense - band.differentiate(q)[0]
    assert np.std(error[1000:-1000]) < 1e-3 * np.std(dense)


def test_a_torque_is_the_same_in_the_band_on_a_coarser_grid():
    rng = np.random.default_rng(5)
    band = Band(rate=1000.0, factor=50, cutoff=8.0, smoothing=24.0)
    thinned = band.thinned(60.0)
    tau = rng.normal(size=(40001, 2))
    every = dataclasses.replace(band, factor=1)
    dense, coarse = every.apply(tau), thinned.apply(thinned.thin(tau))
    samples = (40001, 40000 // thinned.logged + 1)
    at = [b.instants(np.arange(n) / b.rate) for b, n in zip((every, thinned), samples, strict=True)]
    same = np.searchsorted(at[0], at[1] - 1e-6)
    inner = (at[1] > 1) & (at[1] < 39)
    assert np.std((coarse - dense[same])[inner]) < 0.01 * np.std(coarse)
