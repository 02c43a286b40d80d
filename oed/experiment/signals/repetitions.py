"""Averages over repetitions of one motion, and the noise that their spread reveals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.experiment.signals.resampling import Interpolation, resample


@dataclass(frozen=True)
class RepetitionAverage:
    """Mean over M repetitions of S samples, and the variance between them.

    Attributes:
        mean: (S, n) mean over the repetitions.
        variance: (n,) pure-error variance of one sample [unit squared]: the spread about the
            mean at the same phase, whatever the model.
        repetitions: M.
        degrees_of_freedom: S (M - 1), of each column's variance.
    """

    mean: Float[ndarray, "phases columns"]
    variance: Float[ndarray, " columns"]
    repetitions: int
    degrees_of_freedom: int


def fold(
    t: Float[ndarray, " samples"],
    x: Float[ndarray, "samples columns"],
    period: float,
    phases: int,
    kind: Interpolation = "cubic",
) -> Float[ndarray, "repetitions phases columns"]:
    """Cut a signal into whole periods, each at the same uniform phases.

    Args:
        t: (N,) instants [s]; the first opens the first period.
        x: (N, n) samples.
        period: [s].
        phases: Samples S per period, the first at its start.
        kind: Interpolation between samples.

    Returns:
        (M, S, n) samples of the M whole periods recorded.

    Raises:
        ValueError: If not one whole period was recorded.
    """
    step = period / phases
    # A recording of whole periods ends one step before the next begins.
    repetitions = int(np.floor((t[-1] - t[0] + step) / period + 1e-6))
    if repetitions < 1:
        raise ValueError(f"{t[-1] - t[0]:g} s hold no whole period of {period:g} s")
    grid = t[0] + np.arange(repetitions * phases) * step
    # Steps of the log that are coarser than the grid's leave its last instants just outside.
    grid = np.minimum(grid, t[-1])
    return resample(t, x, grid, kind).reshape(repetitions, phases, x.shape[1])


def fold_by_index(
    x: Float[ndarray, "samples columns"], repetition: Int[ndarray, " samples"]
) -> Float[ndarray, "repetitions phases columns"]:
    """Cut a signal into the repetitions that `repetition` (N,) numbers, sample by sample.

    Raises:
        ValueError: If the repetitions differ in their number of samples.
    """
    indices, counts = np.unique(repetition, return_counts=True)
    if len(set(counts.tolist())) != 1:
        raise ValueError(
            f"repetitions hold {counts.min()} to {counts.max()} samples; fold by period instead"
        )
    return np.stack([x[repetition == index] for index in indices])


def average_repetitions(
    folded: Float[ndarray, "repetitions phases columns"],
) -> RepetitionAverage:
    """Mean and pure-error variance of repeated samples (Calafiore 2001, section 3).

    sigma_i^2 = 1 / (S (M - 1)) sum_k sum_j (x_ij(k) - mean_i(k))^2, M repetitions j of S
    instants k.

    Raises:
        ValueError: If there are fewer than two repetitions.
    """
    repetitions, phases, _ = folded.shape
    if repetitions < 2:
        raise ValueError(f"{repetitions} repetition shows no spread; at least 2")
    mean = folded.mean(axis=0)
    freedom = phases * (repetitions - 1)
    variance = ((folded - mean) ** 2).sum(axis=(0, 1)) / freedom
    return RepetitionAverage(mean, variance, repetitions, freedom)
