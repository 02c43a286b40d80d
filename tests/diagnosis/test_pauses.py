"""Recordings of which pauses leave too little."""

import dataclasses

import pytest

from oed.diagnosis.data.prepare import prepare
from oed.diagnosis.settings import DiagnosisSettings
from tests.diagnosis.arm import data_set

EVERY, PAUSE = 0.9, 0.15  # [s]


@pytest.mark.parametrize("role", ["estimation", "validation", "test"])
def test_a_recording_without_a_stretch_as_long_as_the_filter_is_refused_by_name(role):
    """Its errors would be those of no row at all, and pass every test."""
    whole = data_set(2, repetitions=1).recordings
    recordings = []
    for recording in whole:
        kept = (recording.t % EVERY > PAUSE) | (recording.role != role)
        recordings.append(
            dataclasses.replace(
                recording,
                t=recording.t[kept],
                q=recording.q[kept],
                tau=recording.tau[kept],
                repetition=None,
                period=None,
            )
        )
    with pytest.raises(ValueError, match=rf"{role}_\d: between its pauses no stretch is long"):
        prepare(tuple(recordings), DiagnosisSettings())
