"""Repetitions are cut out where they are."""

import numpy as np
import pytest

from oed.experiment.signals.repetitions import fold_by_index


def test_cuts_out_the_repetitions_that_are_numbered():
    x = np.arange(24.0).reshape(12, 2)
    folded = fold_by_index(x, np.array([4, 4, 4, 2, 2, 2, 7, 7, 7, 3, 3, 3]))
    assert np.array_equal(folded, x.reshape(4, 3, 2)[[1, 3, 0, 2]])


def test_refuses_repetitions_of_unequal_length():
    with pytest.raises(ValueError, match="2 to 3 samples"):
        fold_by_index(np.zeros((5, 1)), np.array([0, 0, 0, 1, 1]))
