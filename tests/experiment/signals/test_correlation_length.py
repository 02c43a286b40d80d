"""Rows that count as one, where their autocorrelation is known."""

import numpy as np
import pytest
from scipy.signal import lfilter

from oed.experiment.signals.correlation_length import correlation_length


@pytest.mark.parametrize("memory", [0.0, 0.6, 0.9])
def test_a_signal_with_memory_has_the_rows_of_its_sum(memory):
    """x(k + 1) = a x(k) + e(k): the sum of a^|k| is (1 + a) / (1 - a)."""
    noise = np.random.default_rng(1).normal(size=(20, 4000))
    found = correlation_length(list(lfilter([1.0], [1.0, -memory], noise)))
    assert found == pytest.approx((1 + memory) / (1 - memory), rel=0.05)


def test_stretches_are_not_correlated_with_each_other():
    noise = np.random.default_rng(2).normal(size=4000)
    assert correlation_length([noise[:1000], noise[:1000], noise[1000:]]) == pytest.approx(
        1, rel=0.15
    )


def test_nothing_left_is_not_correlated():
    assert correlation_length([np.zeros(10)]) == 1.0
