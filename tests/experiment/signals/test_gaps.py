"""What counts as a gap in a log's time."""

import numpy as np

from oed.experiment.signals.gaps import find_gaps


def test_a_step_of_more_than_ten_samples_is_a_gap() -> None:
    t = np.cumsum([0.0, *[0.01] * 5, 0.099, *[0.01] * 5, 0.101, *[0.01] * 5])
    assert find_gaps(t, 1000.0).tolist() == [11]


def test_what_is_missed_at_a_rate_beyond_the_needed_one_is_none() -> None:
    t = np.cumsum([0.0, *[0.001] * 50, 0.02, *[0.001] * 50])
    assert find_gaps(t, 1000.0).tolist() == [50]
    assert find_gaps(t, 400.0).tolist() == []


def test_a_single_sample_has_none() -> None:
    assert find_gaps(np.array([3.0]), 100.0).tolist() == []
