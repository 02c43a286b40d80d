"""A joint that stops: friction holds it anywhere between its two heights, and stays there."""

import numpy as np
import pytest

from oed.estimation.noise_floor.autoregression import Autoregression
from oed.estimation.noise_floor.weighted_rows import weigh
from oed.experiment.preparation.prepare import prepare
from oed.experiment.recording import Recording

RATE, MOVE, STOPS = 500.0, 1.0, 8
COULOMB, NOISE = 2.0, 0.1  # [N m]


def recording(pause):
    """A joint that goes to and fro, with a pause after each move [s], and one that never stops."""
    s = np.arange(round(MOVE * RATE)) / (MOVE * RATE)
    rise = 10 * s**3 - 15 * s**4 + 6 * s**5
    rest = round(pause * RATE)
    there = np.concatenate([rise, np.ones(rest), 1 - rise, np.zeros(rest)])
    q = np.tile(there, STOPS // 2)
    t = np.arange(len(q)) / RATE
    q = np.stack([q, 0.5 * np.sin(2 * np.pi * 0.31 * t)], axis=1)
    q += 1e-6 * np.random.default_rng(0).normal(size=q.shape)
    return Recording("stops", "estimation", t, q, np.zeros_like(q))


@pytest.mark.parametrize("pause", [0.3, 0.6, 1.2])
def test_all_rows_of_a_stop_tell_no_more_than_one(pause):
    prepared = prepare((recording(pause),))
    noise = (Autoregression.white(NOISE),) * 2
    rows = weigh(prepared, noise, np.array([COULOMB, COULOMB]))
    turn = np.mod(prepared[0].t, MOVE + pause)
    stopped = (turn > MOVE) & (turn < MOVE + pause)
    told = np.sum(rows.weights[stopped, 0] ** 2) / STOPS
    # Friction anywhere between both heights is even over twice the height.
    one = NOISE**2 / (NOISE**2 + COULOMB**2 / 3)
    assert told < 1.2 * one
    assert np.mean(rows.weights[~stopped, 0] > 0.9) > 0.5


def test_a_turn_on_the_way_is_no_stop():
    prepared = prepare((recording(0.6),))
    noise = (Autoregression.white(NOISE),) * 2
    weights = weigh(prepared, noise, np.array([COULOMB, COULOMB])).weights[:, 1]
    # In doubt are the two samples between which it turns: in the band, a share of its friction.
    doubtful = COULOMB / np.sqrt(3) * 2 * prepared[0].band.taps.max()
    assert weights.min() == pytest.approx(NOISE / np.hypot(NOISE, doubtful), rel=0.1)
