import numpy as np
import pytest

from oed.report.envelope import envelope


def test_a_long_signal_keeps_its_peaks_and_becomes_short() -> None:
    rng = np.random.default_rng(1)
    t = np.arange(30_000) * 1e-3
    y = rng.normal(size=t.size)
    y[12_345], y[23_456] = 50.0, -40.0
    ts, ys = envelope(t, y, bins=500)
    assert len(ts) <= 1000
    assert (ys.max(), ys.min()) == (50.0, -40.0)
    assert ts[ys.argmax()] == t[12_345]
    assert np.all(np.diff(ts) > 0)


def test_a_short_signal_is_left_alone() -> None:
    t = np.linspace(0, 1, 100)
    assert envelope(t, t, bins=50)[1] is t


def test_a_gap_stays_a_gap() -> None:
    t = np.arange(10_000.0)
    y = np.ones(10_000)
    y[4000:6000] = np.nan
    ts, ys = envelope(t, y, bins=100)
    np.testing.assert_array_equal(np.isnan(ys), (ts >= 4000) & (ts < 6000))


@pytest.mark.parametrize("samples", [201, 1000, 1001])
def test_first_and_last_bins_are_drawn(samples: int) -> None:
    t = np.arange(float(samples))
    ts, _ = envelope(t, t, bins=100)
    assert (ts[0], ts[-1]) == (0.0, samples - 1)
