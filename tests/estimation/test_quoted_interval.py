"""Intervals hold the truth in 95 of 100 estimates that are quoted, however few of all these are."""

import numpy as np
import pytest
from scipy import stats

from oed.estimation.quoted_interval import lower_bounds

QUOTED = 2.0
DRAWS = 400_000


@pytest.mark.parametrize("truth", [0.0, 1.0, 2.0, 3.0, 6.0])
def test_quoted_intervals_hold_the_truth(truth):
    rng = np.random.default_rng(7)
    estimates = truth + rng.standard_normal(DRAWS)
    quoted = estimates[np.abs(estimates) > QUOTED][:4000]
    sign, size = np.sign(quoted), np.abs(quoted)
    lower = lower_bounds(size, QUOTED, np.full(len(size), np.inf), 0.95)
    upper = size + stats.norm.ppf(0.975)
    held = np.mean((lower <= sign * truth) & (sign * truth <= upper))
    ordinary = np.mean(np.abs(quoted - truth) <= stats.norm.ppf(0.975))
    assert held > 0.945
    assert truth > 0 or ordinary == 0.0


def test_the_bound_is_that_of_the_truncated_distribution():
    """Of estimates that are quoted, 1 in 40 are as large as this where the truth is at the bound."""
    size = np.array([2.05, 2.5, 3.2, 4.0])
    lower = lower_bounds(size, QUOTED, np.full(4, np.inf), 0.95)
    tail = stats.norm.sf(size - lower) / (
        stats.norm.sf(QUOTED - lower) + stats.norm.cdf(-QUOTED - lower)
    )
    assert tail == pytest.approx(np.full(4, 0.025), rel=1e-6)


def test_far_from_the_threshold_nothing_changes():
    size = np.array([8.0, 30.0])
    lower = lower_bounds(size, QUOTED, np.array([50.0, 50.0]), 0.95)
    assert lower == pytest.approx(size - stats.t.ppf(0.975, 50), abs=1e-3)
