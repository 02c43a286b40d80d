"""Motions that nobody has run yet are laid out as those that were."""

import numpy as np
import pytest

from oed.diagnosis.discrimination.next_motion import error_rate
from oed.diagnosis.discrimination.unrun_motions import AMPLITUDES, HARMONICS, random_motions
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import PERIOD, data_set


def test_a_motion_lasts_as_long_as_a_recording_of_one_run_with_the_edges_that_are_cut():
    dataset = data_set(3, repetitions=1)
    (pattern, *_) = prepare(dataset.estimation)
    step = 1 / pattern.band.rate
    rng = np.random.default_rng(4)
    count = 1 + len(HARMONICS) * (len(AMPLITUDES) - 1)
    motions, _ = random_motions(dataset.robot, pattern, rng, count)
    assert len(motions) == count
    for motion in motions:
        assert motion.t[-1] + step == pytest.approx(PERIOD, abs=2 * step)
        assert np.diff(motion.t) == pytest.approx(step)
    # The last is of the smallest amplitude.
    first, last = (np.ptp(m.q, axis=0) for m in (motions[0], motions[-1]))
    assert (last < 0.5 * first).all()


def test_models_that_do_not_differ_are_confused_in_half_of_all_cases():
    """The favourite's log score leads by lambda / 2, with a variance of lambda."""
    draws = np.random.default_rng(5).normal(size=200_000)
    assert error_rate(0.0) == pytest.approx(0.5)
    assert error_rate(4.0) == pytest.approx(np.mean(4.0 / 2 + 2.0 * draws < 0), abs=0.005)
