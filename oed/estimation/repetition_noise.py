"""The torque's noise as its repetitions show it (Calafiore 2001, section 4)."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.weights import variances_from_repetitions
from oed.experiment.processing import ProcessedRecording
from oed.experiment.signals.repetitions import fold_by_index


def repetition_noise(
    recordings: tuple[ProcessedRecording, ...],
) -> Float[ndarray, " joints"] | None:
    """Torque variance (n,) between repetitions, None where no recording repeats [N^2 m^2].

    Repetitions are cut to their common length, without those at an end of a recording.
    """
    variances, weights = [], []
    for recording in recordings:
        folded = _folded(recording)
        if folded is not None:
            variances.append(variances_from_repetitions(folded))
            weights.append(folded.shape[0] * folded.shape[1])
    return np.average(variances, axis=0, weights=weights) if variances else None


def _folded(
    recording: ProcessedRecording,
) -> Float[ndarray, "repetitions samples joints"] | None:
    if recording.repetition is None:
        return None
    indices, counts = np.unique(recording.repetition, return_counts=True)
    # The first and the last are cut at an end, and no longer start at the same phase.
    indices, counts = indices[1:-1], counts[1:-1]
    whole = indices[counts >= counts.max(initial=0) - 1]
    if len(whole) < 2:
        return None
    length = counts[np.isin(indices, whole)].min()
    position = np.zeros(len(recording), dtype=int)
    for index in whole:
        members = recording.repetition == index
        position[members] = np.arange(members.sum())
    kept = np.isin(recording.repetition, whole) & (position < length)
    return fold_by_index(recording.tau[kept], recording.repetition[kept])
