"""Recordings of which pauses leave too little."""

import dataclasses

import numpy as np
import pytest

from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.settings import choose_settings
from tests.diagnosis.arm import data_set, once

EVERY, PAUSE = 0.6, 0.15  # [s]


@pytest.mark.parametrize("role", ["estimation", "validation", "test"])
def test_a_recording_without_a_stretch_as_long_as_the_filter_is_refused_by_name(role):
    """Its errors would be those of no row at all, and pass every test."""
    recordings = tuple(
        once(recording, (recording.t % EVERY > PAUSE) | (recording.role != role))
        for recording in data_set(2, repetitions=1).recordings
    )
    with pytest.raises(ValueError, match=rf"{role}_\d: between its pauses no stretch is long"):
        prepare(recordings)


def test_a_pause_of_years_fills_no_memory():
    """A clock that was set while the log ran."""
    recordings = data_set(2, repetitions=1).recordings
    first = recordings[0]
    late = np.where(np.arange(len(first)) < len(first) // 2, 0.0, 1e9)
    set_clock = dataclasses.replace(first, t=first.t + late)
    with pytest.raises(ValueError, match=rf"{first.name}: with its pauses it lasts 1e\+09 s"):
        choose_settings((set_clock, *recordings[1:]))
