"""Weighted sums of windows, against the definition written out."""

import numpy as np
import pytest

from oed.experiment.signals.moving_sum import moving_sum, windows

WEIGHTS = np.array([0.5, -1.0, 2.0])


@pytest.mark.parametrize("step", [1, 2, 3])
@pytest.mark.parametrize("columns", [(), (2,), (2, 3)])
def test_sums_whole_windows_in_the_order_of_the_samples(columns, step):
    x = np.random.default_rng(0).normal(size=(8, *columns))
    expected = [sum(w * x[k + i] for i, w in enumerate(WEIGHTS)) for k in range(0, 6, step)]
    assert moving_sum(x, WEIGHTS, step) == pytest.approx(np.array(expected))


@pytest.mark.parametrize("laid_out", ["rows", "columns", "neither", "reversed"])
def test_does_not_mind_how_the_signal_lies_in_memory(laid_out):
    plain = np.random.default_rng(1).normal(size=(9, 4))
    x = {
        "rows": plain,
        "columns": np.asfortranarray(plain),
        "neither": np.repeat(plain, 2, axis=1)[:, ::2],
        "reversed": plain[::-1].copy()[::-1],
    }[laid_out]
    expected = [sum(w * plain[k + i] for i, w in enumerate(WEIGHTS)) for k in range(0, 7, 2)]
    assert moving_sum(x, WEIGHTS, 2) == pytest.approx(np.array(expected))
    assert windows(x, 3, 2)[1, 2] == pytest.approx(plain[2:5, 2])


def test_has_no_row_where_no_window_is_whole():
    assert moving_sum(np.ones((2, 4)), WEIGHTS).shape == (0, 4)
    assert moving_sum(np.ones((3, 4)), WEIGHTS).shape == (1, 4)
