"""The shape checks that every other test relies on are really on."""

import numpy as np
import pytest
from jaxtyping import TypeCheckError

from oed.report.estimation_plots import plot_torques


def test_disagreeing_shapes_are_refused() -> None:
    with pytest.raises(TypeCheckError):
        plot_torques(np.zeros(5), np.zeros((5, 2)), np.zeros((4, 2)), ["a", "b"])
