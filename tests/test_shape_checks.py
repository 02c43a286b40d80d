"""The shape checks that every other test relies on are really on."""

import numpy as np
import pytest
from jaxtyping import TypeCheckError

from oed.estimation.noise_floor.autoregression import Autoregression
from oed.report.estimation_plots import plot_torques
from tests.shape_checks import CALLS, begin_anew


def test_disagreeing_shapes_are_refused() -> None:
    with pytest.raises(TypeCheckError):
        plot_torques(np.zeros(5), np.zeros((5, 2)), np.zeros((4, 2)), ["a", "b"])


def test_methods_and_dataclasses_are_checked() -> None:
    with pytest.raises(TypeCheckError):
        Autoregression(np.zeros((2, 2)), 1.0)
    with pytest.raises(TypeCheckError):
        Autoregression(np.ones(1), 1.0).whiten(np.zeros(5, dtype=int))


def test_first_calls_are_checked_in_every_file_and_no_others() -> None:
    noise, wrong = Autoregression(np.ones(1), 1.0), np.zeros(5, dtype=int)
    for _ in range(CALLS + 1):
        noise.whiten(np.zeros((5, 1)))
    noise.whiten(wrong)
    begin_anew()
    with pytest.raises(TypeCheckError):
        noise.whiten(wrong)
