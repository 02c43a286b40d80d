"""Uniform grids and stale rows."""

import numpy as np
import pytest

from oed.experiment.signals.resampling import fresh_rows, resample, uniform_grid


def irregular(rng: np.random.Generator, samples: int = 2000) -> np.ndarray:
    return np.cumsum(rng.uniform(0.0005, 0.0015, samples))


# With steps h and frequency w linear interpolation errs by (h w)^2 / 8 at most.
HW = 0.0015 * 2 * np.pi * 5


def test_a_sinusoid_survives_resampling():
    t = irregular(np.random.default_rng(0))
    grid = uniform_grid(t, 1000.0)
    x = np.stack([np.sin(2 * np.pi * 3 * t), np.cos(2 * np.pi * 5 * t)], axis=1)
    expected = np.stack([np.sin(2 * np.pi * 3 * grid), np.cos(2 * np.pi * 5 * grid)], axis=1)
    inside = slice(5, -5)
    assert np.abs(resample(t, x, grid) - expected)[inside].max() < HW**2 / 8


def test_a_uniform_signal_is_returned_as_it_is():
    t = 1.7e9 + np.arange(1000) / 1000  # seconds since 1970
    grid = uniform_grid(t, 1000.0)
    assert len(grid) == 1000
    x = np.random.default_rng(0).normal(size=1000)
    assert np.allclose(resample(t, x, grid), x, rtol=0, atol=1e-2)


def test_stale_rows_are_found_only_where_all_signals_repeat():
    q = np.array([[0.0], [1.0], [1.0], [1.0], [2.0]])
    tau = np.array([[0.0], [5.0], [5.0], [6.0], [6.0]])
    assert fresh_rows(q, tau).tolist() == [True, True, False, True, True]


def test_a_standstill_is_no_stale_row():
    q = np.concatenate([np.arange(3.0), np.full(50, 2.0), [3.0, 3.0, 4.0]])[:, None]
    fresh = fresh_rows(q, longest=20)
    assert fresh[:53].all()
    assert fresh[53:].tolist() == [True, False, True]


def test_dropping_stale_rows_comes_closer_to_the_truth():
    rng = np.random.default_rng(1)
    t = irregular(rng)
    x = np.sin(2 * np.pi * 3 * t)[:, None]
    read = x.copy()
    stale = np.flatnonzero(rng.uniform(size=len(t)) < 0.05)
    for k in stale[stale > 0]:
        read[k] = read[k - 1]
    fresh = fresh_rows(read)
    grid = uniform_grid(t, 1000.0)[10:-10]
    truth = np.sin(2 * np.pi * 3 * grid)[:, None]
    kept = np.abs(resample(t, read, grid) - truth).max()
    dropped = np.abs(resample(t[fresh], read[fresh], grid) - truth).max()
    assert dropped < 0.02 * kept


def test_refuses_to_extrapolate():
    t = np.arange(10.0)
    with pytest.raises(ValueError, match="leaves the recording"):
        resample(t, t, np.array([-0.1, 1.0]))
