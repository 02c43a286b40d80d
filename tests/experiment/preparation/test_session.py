"""What changes once in a session, in a recording of its own clock: where it is put, and found."""

import dataclasses

import numpy as np
import pytest

from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import PERIOD, data_set

MASS, REACH = 1.5, 0.25  # [kg], [m] from the second joint


def shifted(dataset, gap):
    """The same on one clock, with pauses."""
    recordings = []
    start = 100.0
    for r in dataset.recordings:
        recordings.append(dataclasses.replace(r, t=r.t + start))
        start += r.duration + gap
    return tuple(recordings)


def test_recordings_of_their_own_clocks_lie_end_to_end_as_they_are_listed():
    dataset = data_set(0)
    prepared = prepare(dataset.recordings)
    starts = [p.motion.t[0] for p in prepared]
    assert np.diff(starts) == pytest.approx(3 * PERIOD, abs=0.01)
    # Where the log has a clock that goes on, time stays as it was logged.
    apart = prepare(shifted(dataset, 5.0))
    assert np.diff([p.motion.t[0] for p in apart]) == pytest.approx(3 * PERIOD + 5, abs=0.01)
    assert apart[0].motion.t[0] == pytest.approx(100.0, abs=0.2)
