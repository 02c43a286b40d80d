"""The paper's on-line filter: what its three numbers amount to."""

import numpy as np
import pytest

from oed.experiment.signals.online_filter import PAPER_FILTER, SecondOrderFilter


def test_the_papers_filter_has_unit_gain_at_rest():
    assert PAPER_FILTER.dc_gain == pytest.approx(1, abs=1e-12)
    assert np.allclose(PAPER_FILTER.apply(np.full(100, 3.0)), 3.0, rtol=0, atol=1e-9)


def test_the_papers_cut_off_is_about_14_rad_per_s():
    frequency = PAPER_FILTER.half_power_frequency()
    assert frequency == pytest.approx(14.27, abs=0.005)
    assert abs(PAPER_FILTER.gain(frequency)) == pytest.approx(np.sqrt(0.5), abs=1e-9)


def test_the_papers_filter_has_its_poles_at_20_and_25_rad_per_s():
    poles = np.sort(np.real(-np.log(PAPER_FILTER.poles) / PAPER_FILTER.period))
    assert np.allclose(poles, [20.0, 25.0], rtol=1e-4)


def test_apply_follows_the_recursion():
    u = np.random.default_rng(0).normal(size=(50, 2))
    y = PAPER_FILTER.apply(u)
    for k in range(2, 50):
        f = PAPER_FILTER
        assert np.allclose(y[k], f.l1 * u[k] + f.l2 * y[k - 1] + f.l3 * y[k - 2], rtol=1e-12)


def test_a_sinusoid_comes_out_with_the_gain_stated():
    frequency, steps = 20.0, np.arange(20000)
    y = PAPER_FILTER.apply(np.sin(frequency * PAPER_FILTER.period * steps))
    gain = PAPER_FILTER.gain(frequency)
    expected = np.imag(gain * np.exp(1j * frequency * PAPER_FILTER.period * steps))
    assert np.allclose(y[5000:], expected[5000:], rtol=0, atol=1e-9)


def test_a_double_pole_is_found_where_it_was_put():
    """Critical damping: unit gain at rest, both poles at -30 rad/s."""
    decay = np.exp(-30.0 * 0.001)
    filter_ = SecondOrderFilter((1 - decay) ** 2, 2 * decay, -(decay**2), 0.001)
    assert filter_.dc_gain == pytest.approx(1, abs=1e-9)
    assert np.allclose(filter_.poles, np.exp(-0.03), rtol=0, atol=1e-6)
    # |1 + jw/p|^2 = sqrt(2) at w = p sqrt(sqrt(2) - 1)
    expected = 30.0 * np.sqrt(np.sqrt(2) - 1)
    assert filter_.half_power_frequency() == pytest.approx(expected, rel=1e-3)


def test_refuses_an_unstable_filter():
    with pytest.raises(ValueError, match="unstable"):
        SecondOrderFilter(0.1, 2.0, -0.9, 0.001)
