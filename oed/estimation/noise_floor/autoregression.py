"""Autoregressive whitening: coloured noise made white, so that a sum of squares is a chi-square.

An autoregression of the noise is estimated by Yule and Walker's equations from pure error, and
its prediction-error filter is applied to torque and columns alike (generalised least squares).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.linalg import cho_factor, cho_solve, solve_toeplitz, toeplitz
from scipy.signal import lfilter

from oed.experiment.signals.moving_sum import moving_sum

LARGEST_ORDER = 24
# Least power of the spectrum as a share of its mean: beyond the band's edge there is nothing,
# and the inverse of nothing would be noise of the arithmetic.
FLOOR = 1e-3
RESPONSE = 2000  # rows after which an innovation is forgotten
LEAST_DEVIATION = 1e-9  # [unit of x] of noise where a model leaves nothing
CHUNK = 256  # rows whose joint likelihood is taken at once
TAPER = 4  # lags that the tapered covariance reaches, in largest orders


@dataclass(frozen=True)
class Autoregression:
    """x(k) + a_1 x(k-1) + ... + a_p x(k-p) = scale e(k), with e of unit variance.

    Attributes:
        coefficients: (p + 1,) with the leading 1.
        scale: Standard deviation of the innovation [unit of x].
    """

    coefficients: Float[ndarray, " lags"]
    scale: float

    @classmethod
    def white(cls, deviation: float) -> Autoregression:
        """Noise without colour, of a standard deviation that is never quite zero."""
        return cls(np.ones(1), max(float(deviation), LEAST_DEVIATION))

    @property
    def order(self) -> int:
        """P."""
        return len(self.coefficients) - 1

    @cached_property
    def deviation(self) -> float:
        """Standard deviation of the noise itself [unit of x]."""
        response = np.asarray(lfilter([1.0], self.coefficients, np.eye(1, RESPONSE)[0]))
        return float(self.scale * np.sqrt(np.sum(response**2)))

    def whiten(self, x: Float[ndarray, " rows *columns"]) -> Float[ndarray, " rows *columns"]:
        """Innovations of unit variance; the first p rows lack their past and are approximate."""
        if not self.order:
            return x / self.scale
        before = np.zeros((self.order, *x.shape[1:]))
        return moving_sum(np.concatenate([before, x]), self.coefficients[::-1]) / self.scale

    def with_scale(self, factor: float) -> Autoregression:
        """The same colour with its standard deviation multiplied."""
        return Autoregression(self.coefficients, self.scale * factor)


def fit_autoregression(
    series: Sequence[Float[ndarray, " _"]],
    *,
    trusted: Sequence[Bool[ndarray, " _"]] | None = None,
    edge: float = 1.0,
) -> Autoregression:
    """Autoregression of several stretches of one noise, its order by Schwarz's criterion.

    Args:
        series: Stretches of noise of zero mean.
        trusted: Which rows of each stretch show nothing but noise; all if None.
        edge: Cut-off of the rows' low-pass, of their Nyquist frequency. Whitening raises what lies
            beyond no more than what lies there: else it would undo the low-pass.
    """
    masks = [np.ones(len(x), dtype=bool) for x in series] if trusted is None else trusted
    clean = [np.where(m, x, 0.0) for x, m in zip(series, masks, strict=True)]
    rows = sum(int(m.sum()) for m in masks)
    longest = int(min(LARGEST_ORDER, max(1, min(len(x) for x in series) // 8)))
    shortest = min(len(x) for x in series)
    heard = _covariance(clean, masks, min(TAPER * longest, shortest - 1))
    covariance = _beyond_as_at(heard, edge)[: longest + 1]
    if covariance[0] <= 0:
        return Autoregression(np.ones(1), np.finfo(float).tiny ** 0.5)
    best, best_value = np.ones(1), np.inf
    for order in range(longest + 1):
        lags = (
            solve_toeplitz(covariance[:order], -covariance[1 : order + 1]) if order else np.zeros(0)
        )
        innovation = covariance[0] + float(lags @ covariance[1 : order + 1])
        if innovation <= 0:
            break
        value = rows * np.log(innovation) + order * np.log(rows)
        if value < best_value:
            best, best_value = np.concatenate([[1.0], lags]), value
    # What was put beyond the edge is part of the noise for which rows are held.
    whole, own = (best @ toeplitz(c[: len(best)]) @ best for c in (covariance, heard))
    return Autoregression(best, _scale(best, clean, masks) * float(np.sqrt(whole / own)))


def _scale(
    coefficients: Float[ndarray, " lags"],
    clean: Sequence[Float[ndarray, " _"]],
    masks: Sequence[Bool[ndarray, " _"]],
) -> float:
    """The most likely deviation of the innovations, of the rows that are trusted alone.

    By their covariance among one another: at the edge of a gap, the filter would make a leap of
    what is missing, and far from all gaps there may be few rows, and quiet ones.
    """
    response = np.asarray(lfilter([1.0], coefficients, np.eye(1, RESPONSE)[0]))
    reach = min(CHUNK, RESPONSE)
    lags = np.array([response[k:] @ response[: RESPONSE - k] for k in range(reach)])
    squares, count = 0.0, 0
    for x, mask in zip(clean, masks, strict=True):
        for start in range(0, len(x), CHUNK):
            own = np.flatnonzero(mask[start : start + CHUNK])
            if len(own):
                among = lags[np.abs(own[:, None] - own)]
                white = cho_solve(cho_factor(among, lower=True), x[start + own])
                squares += float(x[start + own] @ white)
                count += len(own)
    return float(np.sqrt(squares / max(count, 1)))


def _covariance(
    clean: Sequence[Float[ndarray, " _"]], masks: Sequence[Bool[ndarray, " _"]], longest: int
) -> Float[ndarray, " lags"]:
    """Autocovariance over pairs of trusted rows.

    Gaps can make it that of no spectrum: it is tapered, and its spectrum is kept above a floor.
    """
    result = np.zeros(longest + 1)
    for lag in range(longest + 1):
        pairs = sum(int((m[lag:] & m[: len(m) - lag]).sum()) for m in masks)
        products = sum(float(x[lag:] @ x[: len(x) - lag]) for x in clean)
        result[lag] = products / max(pairs, 1)
    result *= 0.5 + 0.5 * np.cos(np.pi * np.arange(longest + 1) / (longest + 1))
    return _covariance_of(np.maximum(_spectrum_of(result), FLOOR * result[0]))


def _beyond_as_at(covariance: Float[ndarray, " lags"], edge: float) -> Float[ndarray, " lags"]:
    """Autocovariance of noise whose spectrum is nowhere lower beyond an edge than at it."""
    spectrum = _spectrum_of(covariance)
    first = min(round(edge * (len(spectrum) - 1)), len(spectrum) - 1)
    spectrum[first:] = np.maximum(spectrum[first:], spectrum[first])
    return _covariance_of(spectrum)


def _spectrum_of(covariance: Float[ndarray, " lags"]) -> Float[ndarray, " lags"]:
    """From zero to the Nyquist frequency, of an even autocovariance."""
    return np.fft.rfft(np.concatenate([covariance, covariance[:0:-1]])).real


def _covariance_of(spectrum: Float[ndarray, " lags"]) -> Float[ndarray, " lags"]:
    """The inverse."""
    lags = len(spectrum)
    return np.fft.irfft(spectrum, 2 * lags - 1)[:lags]
