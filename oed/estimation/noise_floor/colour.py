"""The colour of noise as a fit leaves it, with what the fit took of it given back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray
from scipy.ndimage import uniform_filter1d

OCTAVES = 9  # into which frequencies are divided
# Share of the noise that a fit must leave of an octave to tell how loud it is there. Elsewhere it is
# as loud as in the octaves next to it that tell; slower than all of these, most is louder still.
LEAST_LEFT = 0.3
LAGS = 512  # frequencies from which the autocorrelation is made
NEIGHBOURS = 9  # frequencies over which it is averaged: noise has a smooth colour
REMEMBERED = 64  # lengths of recordings


@dataclass(frozen=True)
class Stretches:
    """Rows of several recordings, one after another.

    Attributes:
        starts: First row of each, and the end.
        seen: (R,) rows at which a fit has looked.
    """

    starts: tuple[int, ...]
    seen: Bool[ndarray, " rows"]

    def taken_by(self, basis: Float[ndarray, "seen_rows rank"]) -> list[Float[ndarray, " _"]]:
        """Share of the noise that a fit takes, of each recording, at each frequency of `rfft`.

        Args:
            basis: Its orthonormal columns.
        """
        whole = self.whole(basis)
        return [taken_of_noise(whole[a:b]) for a, b in pairwise(self.starts)]

    def whole(self, values: Float[ndarray, " seen_rows *axes"]) -> Float[ndarray, " rows *axes"]:
        """Values at the rows that are seen, zero at the others."""
        result = np.zeros((len(self.seen), *values.shape[1:]))
        result[self.seen] = values
        return result


@dataclass(frozen=True)
class Colour:
    """Power of stationary noise, in octaves.

    Attributes:
        power: (octaves,) mean square of white noise as loud, the slowest octave first; octave k
            ends at 2^(k - octaves) of a cycle a row.
    """

    power: Float[ndarray, " octaves"]

    @classmethod
    def of(
        cls,
        residual: Float[ndarray, " seen_rows"],
        taken: Sequence[Float[ndarray, " _"]],
        stretches: Stretches,
    ) -> Colour:
        """The colour of the noise that a fit has left.

        Args:
            residual: What it leaves.
            taken: Share of the noise that it takes.
            stretches: Where it has looked.
        """
        found, left, there = (np.zeros(OCTAVES) for _ in range(3))
        whole = stretches.whole(residual)
        for (a, b), own in zip(pairwise(stretches.starts), taken, strict=True):
            octave, both = _octaves_of(b - a)
            seen = stretches.seen[a:b]
            shares = np.maximum(left_of_noise(own, seen), 0.0) * seen.mean()
            squares = np.abs(np.fft.rfft(whole[a:b])) ** 2 / (b - a)
            found += np.bincount(octave, both * squares, OCTAVES)
            left += np.bincount(octave, both * shares, OCTAVES)
            there += np.bincount(octave, both * seen.mean(), OCTAVES)
        heard = np.flatnonzero(left > LEAST_LEFT * np.maximum(there, 1e-12))
        if not len(heard):  # then nothing says which noise is louder
            return cls(np.full(OCTAVES, found.sum() / max(float(left.sum()), 1.0)))
        return cls(np.interp(np.arange(OCTAVES), heard, found[heard] / left[heard]))

    @property
    def mean_square(self) -> float:
        """Of the noise."""
        ends = 0.5 ** np.arange(OCTAVES)[::-1]
        return float(self.power @ np.diff(ends, prepend=0.0))

    @property
    def correlated_rows(self) -> float:
        """1 + 2 sum of the autocorrelation up to its first zero: rows that count as one."""
        octave, _ = _octaves_of(2 * LAGS)
        covariance = np.fft.irfft(self.power[octave])[:LAGS]
        beyond = np.flatnonzero(covariance <= 0)
        end = beyond[0] if len(beyond) else LAGS
        return float(max(1.0, 2 * covariance[:end].sum() / max(covariance[0], 1e-300) - 1))

    def along(self, taken: Sequence[Float[ndarray, " _"]], stretches: Stretches) -> float:
        """Squares of the noise that a fit takes.

        Args:
            taken: Its share.
            stretches: Where it looks.
        """
        total = 0.0
        for (a, b), own in zip(pairwise(stretches.starts), taken, strict=True):
            octave, both = _octaves_of(b - a)
            total += float((both * self.power[octave]) @ own)
        return total


@lru_cache(maxsize=REMEMBERED)
def _octaves_of(rows: int) -> tuple[Int[ndarray, " frequencies"], Float[ndarray, " frequencies"]]:
    """Octave of each frequency of `rfft`, and how many of `fft` it stands for."""
    frequency = np.fft.rfftfreq(rows)
    slowest = 2.0 ** -(OCTAVES + 1)
    octave = OCTAVES + np.floor(np.log2(np.maximum(frequency, slowest) / 0.5)).astype(int)
    both = np.full(len(frequency), 2.0)
    both[0] = 1.0
    if rows % 2 == 0:
        both[-1] = 1.0
    return np.clip(octave, 0, OCTAVES - 1), both


def taken_of_noise(
    basis: Float[ndarray, "*joints rows rank"],
) -> Float[ndarray, "*joints frequencies"]:
    """Share of the noise of one stretch of rows that a fit takes, at each frequency of `rfft`.

    Args:
        basis: Orthonormal columns of the fit, over all its stretches; these rows of them.
    """
    spectra = np.fft.rfft(basis, axis=-2)
    return np.sum(spectra.real**2 + spectra.imag**2, axis=-1) / basis.shape[-2]


def left_of_noise(
    taken: Float[ndarray, "*joints frequencies"], seen: Bool[ndarray, "*joints rows"]
) -> Float[ndarray, "*joints frequencies"]:
    """Share of the noise of the fitted rows that a fit leaves.

    Args:
        taken: What it takes.
        seen: Rows that were fitted.
    """
    there = np.maximum(seen.mean(axis=-1, keepdims=True), 1 / seen.shape[-1])
    return 1 - uniform_filter1d(taken, NEIGHBOURS, axis=-1) / there
