"""Recordings with gaps are taken apart, and nothing is lost or made up on the way."""

import dataclasses

import numpy as np
import pytest

from oed.experiment.dataset import DataSet
from oed.experiment.recording import Recording
from oed.experiment.stretches import gap_notes, gap_record, split_at_gaps
from oed.robot import imi_scara


def logged(*missing: tuple[float, float]) -> Recording:
    """Twenty seconds at 100 Hz without the rows within the intervals `missing` [s]."""
    t = np.arange(2000) * 0.01
    kept = np.ones(len(t), dtype=bool)
    for a, b in missing:
        kept &= (t <= a) | (t >= b)
    q = np.column_stack([np.sin(t), np.cos(t)])
    whole = (q, 2 * q, 3 * q, (t > 10).astype(int), 20 + q[:, :1])
    q, tau, dq, repetition, temperature = (x[kept] for x in whole)
    return Recording(
        "log", "estimation", t[kept], q, tau, dq, repetition=repetition, temperature=temperature
    )


def of(*recordings: Recording) -> DataSet:
    return DataSet("made", "", "", imi_scara(), "measured", recordings=recordings)


def test_the_stretches_hold_the_rows_of_the_log_in_order() -> None:
    log = logged((5.0, 6.0), (12.0, 12.5))
    parts = split_at_gaps(of(log)).recordings
    assert len({part.name for part in parts}) == len(parts) == 3
    for name in ("t", "q", "tau", "dq", "repetition", "temperature"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        assert np.array_equal(joined, getattr(log, name))
    assert max(np.diff(part.t).max() for part in parts) < 0.011


def test_a_stretch_that_is_too_short_is_left_out() -> None:
    parts = split_at_gaps(of(logged((5.0, 6.0), (7.0, 8.0)))).recordings
    assert [round(part.t[0]) for part in parts] == [0, 8]


def test_a_recording_without_gaps_is_kept_however_short() -> None:
    log = logged((0.5, 20.0))
    assert split_at_gaps(of(log)).recordings == (log,)


def test_refuses_a_recording_of_which_nothing_is_left() -> None:
    often = logged(*[(k + 0.5, k + 1.0) for k in range(20)])
    with pytest.raises(
        ValueError, match=r"log: with 19 gaps .* no stretch of 2 s, the longest is 0\.5"
    ):
        split_at_gaps(of(often))


def test_says_how_many_gaps_and_how_long() -> None:
    other = dataclasses.replace(logged(), name="other")
    record = gap_record(of(logged((5.0, 6.0), (12.0, 12.5)), other))
    assert set(record) == {"log"}
    assert record["log"]["gaps"] == 2
    assert record["log"]["longest_s"] == pytest.approx(1.0)
    assert record["log"]["total_s"] == pytest.approx(1.5)
    assert "2 gap(s)" in gap_notes(record)[0]
    assert gap_notes(gap_record(of(other))) == ()
