"""Recordings for the test have no say in how the others are looked at."""

import dataclasses

import numpy as np
import pytest

from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import data_set, once


def _noisy(recording):
    """With encoders a thousand times as coarse, which would ask for a far narrower band."""
    rng = np.random.default_rng(9)
    q = recording.q + 1e-2 * rng.normal(size=recording.q.shape)
    return dataclasses.replace(recording, q=q)


@pytest.mark.parametrize("change", [_noisy, once])
def test_a_test_recording_changes_nothing_of_the_others(change):
    recordings = data_set(1, step=1e-7).recordings
    other = tuple(change(r) if r.role == "test" else r for r in recordings)
    for one, same in zip(prepare(recordings), prepare(other), strict=True):
        if one.role != "test":
            assert one.band == same.band
            assert np.array_equal(one.torque, same.torque)
            assert np.array_equal(one.motion.ddq, same.motion.ddq)


def test_a_repeated_test_does_not_widen_the_band_of_motions_that_ran_once():
    recordings = data_set(1, step=1e-7).recordings
    single = tuple(once(r) for r in recordings)
    mixed = tuple(r if r.role == "test" else once(r) for r in recordings)
    one, same = (prepare(own)[0].band for own in (single, mixed))
    assert one.cutoff == same.cutoff < prepare(recordings)[0].band.cutoff
