"""Autoregressive noise: fitted to regression residuals without their loss of colour."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import lfilter

LARGEST_REFLECTION = 0.999
IMPULSE_RESPONSE_END = 1e-6
LONGEST_TAIL = 20_000  # [samples]


@dataclass(frozen=True)
class AutoregressiveNoise:
    """Stationary noise a_j(z) v_j = e_j in every joint, e white within and across samples.

    Attributes:
        coefficients: One (m_j + 1,) polynomial [1, a_1, ...] a joint.
        innovation: (n, n) covariance of e.
    """

    coefficients: tuple[ndarray, ...]
    innovation: Float[ndarray, "joints joints"]

    @cached_property
    def tail(self) -> int:
        """Samples after which every impulse response has died away."""
        radius = max(
            (np.abs(np.roots(a)).max() for a in self.coefficients if len(a) > 1), default=0.0
        )
        if radius < 1e-3:
            return max(len(a) for a in self.coefficients)
        return int(min(np.ceil(np.log(IMPULSE_RESPONSE_END) / np.log(radius)) + 20, LONGEST_TAIL))

    def autocovariance(self, lags: int) -> Float[ndarray, "lags joints"]:
        """gamma_j(0 .. lags - 1) of every joint."""
        impulse = np.zeros(max(self.tail, lags) + lags)
        impulse[0] = 1.0
        columns = []
        for joint, a in enumerate(self.coefficients):
            response = np.asarray(lfilter([1.0], a, impulse))
            gamma = [response[: len(response) - lag] @ response[lag:] for lag in range(lags)]
            columns.append(self.innovation[joint, joint] * np.array(gamma))
        return np.column_stack(columns)

    def adjoint_filter(
        self, signals: Float[ndarray, "samples joints columns"]
    ) -> Float[ndarray, "extended joints columns"]:
        """F^T x for v = F e: filtered backwards in time, into a tail before the first sample.

        The noise has gone on for ever when the record begins, so its innovations reach back
        by `tail` samples.
        """
        padded = np.concatenate([np.zeros((self.tail, *signals.shape[1:])), signals])
        return self._filter(padded[::-1])[::-1]

    def cover(
        self, signals: Float[ndarray, "samples joints columns"]
    ) -> Float[ndarray, "samples joints columns"]:
        """Omega x: the covariance of the noise applied to signals."""
        innovations = mix_joints(self.innovation, self.adjoint_filter(signals))
        return self._filter(innovations)[self.tail :]

    def _filter(self, signals: Float[ndarray, "samples joints columns"]) -> ndarray:
        return np.stack(
            [lfilter([1.0], a, signals[:, j], axis=0) for j, a in enumerate(self.coefficients)],
            axis=1,
        )


def mix_joints(
    mixture: Float[ndarray, "joints joints"],
    signals: Float[ndarray, "samples joints columns"],
) -> Float[ndarray, "samples joints columns"]:
    """Each sample's joints times a matrix."""
    return np.moveaxis(np.tensordot(mixture, signals, axes=(1, 1)), 0, 1)


def lagged_sums(
    first: Float[ndarray, " samples joints *columns"],
    second: Float[ndarray, " samples joints *columns"],
    lags: int,
    segments: tuple[int, ...],
) -> Float[ndarray, "lags joints"]:
    """sum_k first_j(k) . second_j(k - l) for l < lags, within segments only."""
    sums = np.zeros((lags, first.shape[1]))
    for start, end in segment_bounds(segments):
        a = first[start:end].reshape(end - start, first.shape[1], -1)
        b = second[start:end].reshape(end - start, first.shape[1], -1)
        for lag in range(min(lags, end - start)):
            sums[lag] += np.einsum("kjc,kjc->j", a[lag:], b[: len(b) - lag])
    return sums


def segment_bounds(segments: tuple[int, ...]) -> list[tuple[int, int]]:
    """Start and end of each segment, from their lengths."""
    ends = np.cumsum(segments)
    return [(int(end - length), int(end)) for end, length in zip(ends, segments, strict=True)]


def levinson(
    autocovariance: Float[ndarray, " lags"], order: int
) -> tuple[Float[ndarray, " order1"], Float[ndarray, " order1"]]:
    """Levinson–Durbin recursion (Brockwell & Davis, Time Series, section 8.2).

    Where an estimated autocovariance is not positive definite the order stops growing.

    Returns:
        The polynomial [1, a_1, ...], at most `order` long, and the innovation variance of
        each order on the way.
    """
    polynomial = np.array([1.0])
    variance = [float(autocovariance[0])]
    for m in range(1, order + 1):
        reflection = -(polynomial @ autocovariance[m:0:-1]) / variance[-1]
        if not abs(reflection) < 1:
            break
        reflection = float(np.clip(reflection, -LARGEST_REFLECTION, LARGEST_REFLECTION))
        polynomial = np.append(polynomial, 0.0)
        polynomial = polynomial + reflection * polynomial[::-1]
        variance.append(variance[-1] * (1 - reflection**2))
    return polynomial, np.array(variance)


def choose_order(autocovariance: Float[ndarray, " lags"], samples: float) -> int:
    """Order with the least corrected Akaike criterion (Hurvich & Tsai 1989)."""
    _, variance = levinson(autocovariance, len(autocovariance) - 1)
    orders = np.arange(len(variance))
    allowed = orders + 3 < samples
    criterion = samples * np.log(np.maximum(variance, np.finfo(float).tiny)) + 2 * (
        orders + 1
    ) * samples / np.maximum(samples - orders - 2, 1)
    return int(np.argmin(np.where(allowed, criterion, np.inf)))
