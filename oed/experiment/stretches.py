"""The stretches of recordings between gaps of the log.

What a filter or a spline makes up across a gap is no measurement.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.counted import counted
from oed.experiment.dataset import DataSet
from oed.experiment.recording import Recording
from oed.experiment.signals.gaps import find_gaps

# Ten steps of this rate are a quarter of the period of a 10 Hz cut-off, usual for an arm: a
# spline bridges less without loss, and loggers of 1 kHz stumble that long.
NEEDED_RATE = 400.0  # [Hz]
LEAST_STRETCH = 2.0  # [s] between gaps; a shorter one shows little of the arm


def gap_lengths(recording: Recording) -> Float[ndarray, " gaps"]:
    """Length of each gap of a recording [s]."""
    return np.diff(recording.t)[find_gaps(recording.t, NEEDED_RATE)]


def split_at_gaps(dataset: DataSet) -> DataSet:
    """The data set with each recording that has gaps replaced by its stretches.

    Args:
        dataset: To split; recordings without a gap are kept as they are.

    Raises:
        ValueError: If no stretch of a recording is long enough.
    """
    recordings = tuple(
        stretch for recording in dataset.recordings for stretch in _stretches(recording)
    )
    return dataclasses.replace(dataset, recordings=recordings)


def gap_record(dataset: DataSet) -> dict[str, dict[str, int | float]]:
    """By name of each recording with gaps: their number, the longest and all together [s]."""
    lengths = {recording.name: gap_lengths(recording) for recording in dataset.recordings}
    return {
        name: {"gaps": len(gaps), "longest_s": float(gaps.max()), "total_s": float(gaps.sum())}
        for name, gaps in lengths.items()
        if len(gaps)
    }


def gap_notes(record: Mapping[str, Mapping[str, int | float]]) -> tuple[str, ...]:
    """A line on each recording with gaps, from `gap_record`."""
    return tuple(
        f"{name}: {gaps['gaps']:g} gap(s) in the log's time, the longest {gaps['longest_s']:.3g} s, "
        f"{gaps['total_s']:.3g} s in all; nothing is estimated from within or next to them"
        for name, gaps in record.items()
    )


def _stretches(recording: Recording) -> tuple[Recording, ...]:
    gaps = find_gaps(recording.t, NEEDED_RATE)
    if not len(gaps):
        return (recording,)
    edges = [0, *(gaps + 1), len(recording)]
    parts = [
        _part(recording, slice(int(a), int(b)), k)
        for k, (a, b) in enumerate(itertools.pairwise(edges), 1)
    ]
    kept = tuple(part for part in parts if part.duration >= LEAST_STRETCH)
    if not kept:
        longest = max(part.duration for part in parts)
        raise ValueError(
            f"{recording.name}: with {counted(len(gaps), 'gap')} in the log's time there is no stretch of "
            f"{LEAST_STRETCH:.3g} s, the longest is {longest:.3g} s; repair the logger, record again, "
            "or leave this recording out"
        )
    return kept


def _part(recording: Recording, rows: slice, number: int) -> Recording:
    def cut(values: ndarray | None) -> ndarray | None:
        return None if values is None else values[rows]

    return dataclasses.replace(
        recording,
        name=f"{recording.name}, stretch {number}",
        t=recording.t[rows],
        q=recording.q[rows],
        tau=recording.tau[rows],
        dq=cut(recording.dq),
        ddq=cut(recording.ddq),
        repetition=cut(recording.repetition),
        temperature=cut(recording.temperature),
    )
