"""Means over designs, test motions and noise that are all drawn, and where their spread is from.

A table y (P, T, E) holds P pairs of designs crossed with T test motions, each cell with E draws
of the noise; T is 1 where no test motion takes part. Pairs and motions are random effects:
experiments that share one are not independent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy import stats

LEVEL = 0.95


@dataclass(frozen=True)
class Interval:
    """A value and its 95 % interval."""

    value: float
    lower: float
    upper: float


@dataclass(frozen=True)
class Sources:
    """Standard deviation of a single experiment by where it is from; 0 where none is seen.

    Attributes:
        pair: Which pair of designs.
        motion: Which test motion.
        both: Which motion after which pair.
        noise: Which draw of the noise.
    """

    pair: float
    motion: float
    both: float
    noise: float


def mean_interval(y: Float[ndarray, "P T E"]) -> Interval:
    """Mean over pairs and motions, with its 95 % interval.

    The variance of the mean is var(means of pairs) / P + var(means of motions) / T, which holds
    that of their interaction and of the noise once too often and so errs on the safe side; its
    degrees of freedom are Satterthwaite's (1946, Biometrics Bulletin 2, 110-114).
    """
    cells = y.mean(axis=2)
    mean = float(cells.mean())
    parts = [
        (means.var(ddof=1) / len(means), len(means) - 1)
        for means in (cells.mean(axis=1), cells.mean(axis=0))
        if len(means) > 1
    ]
    variance = sum(part for part, _ in parts)
    if variance == 0:
        return Interval(mean, mean, mean)
    freedom = variance**2 / sum(part**2 / df for part, df in parts)
    half = float(stats.t.ppf(0.5 + LEVEL / 2, freedom) * np.sqrt(variance))
    return Interval(mean, mean - half, mean + half)


def rate_interval(hits: Bool[ndarray, "clusters draws"]) -> Interval:
    """How often something happens, in per cent, where the draws of a cluster are alike.

    Clopper and Pearson's interval at the effective number of draws (Korn and Graubard 1998,
    Survey Methodology 24, 193-201): the number that would leave the rate as uncertain if they
    were independent, and no more than the clusters where all clusters are the same.
    """
    means = hits.mean(axis=1)
    rate, variance = float(means.mean()), means.var() / len(means)
    count = rate * (1 - rate) / variance if variance > 0 else len(means)
    count = min(count, hits.size)
    tail = 0.5 - LEVEL / 2
    lower = stats.beta.ppf(tail, rate * count, count - rate * count + 1) if rate > 0 else 0.0
    upper = stats.beta.isf(tail, rate * count + 1, count - rate * count) if rate < 1 else 1.0
    return Interval(100 * rate, 100 * float(lower), 100 * float(upper))


def sources_of(y: Float[ndarray, "P T E"]) -> Sources:
    """The parts of the spread, by analysis of variance.

    The noise of the even draws is independent of that of the odd ones: what the means of both
    halves share is from pairs and motions alone.
    """
    noise = float(y.var(axis=2, ddof=1).mean())
    even, odd = (y[:, :, first::2].mean(axis=2) for first in (0, 1))
    P, T = even.shape
    pairs = _covariance(even.mean(axis=1), odd.mean(axis=1), P - 1)
    if T == 1:
        return Sources(_root(pairs), 0.0, 0.0, _root(noise))
    motions = _covariance(even.mean(axis=0), odd.mean(axis=0), T - 1)
    both = _covariance(_interaction(even), _interaction(odd), (P - 1) * (T - 1))
    return Sources(_root(pairs - both / T), _root(motions - both / P), _root(both), _root(noise))


def _interaction(cells: Float[ndarray, "P T"]) -> Float[ndarray, "P T"]:
    """What is left of cells without the means of rows and columns."""
    return cells - cells.mean(axis=1, keepdims=True) - cells.mean(axis=0) + cells.mean()


def _covariance(first: ndarray, second: ndarray, freedom: int) -> float:
    return float(((first - first.mean()) * (second - second.mean())).sum() / freedom)


def _root(variance: float) -> float:
    return float(np.sqrt(max(variance, 0.0)))
