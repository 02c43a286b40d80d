"""What an addition may cost at one joint for what it wins at another."""

import numpy as np
import pytest

from oed.diagnosis.search.judgement import PRICE, WORSE, costs

FLOOR = np.array([0.5, 0.1])
OLD = np.array([1.0, 0.2])


def test_falling_errors_cost_nothing():
    assert not costs(OLD, np.array([0.9, 0.19]), FLOOR)
    assert not costs(OLD, np.array([0.9, 0.19]), FLOOR, price=0.0)


def test_errors_that_rise_together_do():
    assert costs(OLD, np.array([1.01, 0.2]), FLOOR)


@pytest.mark.parametrize(("share", "dear"), [(0.5 * PRICE, False), (2.0 * PRICE, True)])
def test_a_loss_is_weighed_against_the_gain_in_squares_of_the_floor(share, dear):
    gain = (OLD[0] ** 2 - 0.6**2) / FLOOR[0] ** 2
    loser = np.sqrt(OLD[1] ** 2 + share * gain * FLOOR[1] ** 2)
    new = np.array([0.6, loser])
    assert np.mean((new / OLD) ** 2) < 1 or dear
    assert loser > WORSE * OLD[1]
    assert costs(OLD, new, FLOOR) is dear
    assert costs(OLD, new, FLOOR, price=0.0)


def test_a_rise_within_the_margin_is_chance():
    new = np.array([0.6, (WORSE - 0.001) * OLD[1]])
    assert not costs(OLD, new, FLOOR, price=0.0)
