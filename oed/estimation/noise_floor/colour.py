"""The colour of noise as a fit leaves it, with what the fit took of it given back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.fft import irfft, rfft
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
        return [squares.sum(axis=1) for squares in self.squares(basis)]

    def squares(
        self, columns: Float[ndarray, "seen_rows columns"]
    ) -> list[Float[ndarray, "_ columns"]]:
        """Squares of each column's spectrum over the rows, of each recording, as of `rfft`."""
        whole = self.whole(columns)
        spectra = [rfft(whole[a:b], axis=0) / np.sqrt(b - a) for a, b in pairwise(self.starts)]
        return [spectrum.real**2 + spectrum.imag**2 for spectrum in spectra]

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
        sides = [own[:, None] for own in taken]
        return cls(power_of_noise(residual[:, None], sides, stretches)[:, 0])

    @property
    def mean_square(self) -> float:
        """Of the noise."""
        ends = 0.5 ** np.arange(OCTAVES)[::-1]
        return float(self.power @ np.diff(ends, prepend=0.0))

    @property
    def correlated_rows(self) -> float:
        """1 + 2 sum of the autocorrelation up to its first zero: rows that count as one."""
        covariance = np.asarray(irfft(self.power @ (_octaves(2 * LAGS) > 0)))[:LAGS]
        beyond = np.flatnonzero(covariance <= 0)
        end = beyond[0] if len(beyond) else LAGS
        return float(max(1.0, 2 * covariance[:end].sum() / max(covariance[0], 1e-300) - 1))


def power_of_noise(
    residuals: Float[ndarray, "seen_rows fits"],
    taken: Sequence[Float[ndarray, "_ fits"]],
    stretches: Stretches,
) -> Float[ndarray, "octaves fits"]:
    """Power of the noise that each of several fits has left, as of `Colour`.

    Args:
        residuals: What each leaves.
        taken: Share of the noise that it takes, of each recording.
        stretches: Where they have looked.
    """
    found, left = (np.zeros((OCTAVES, residuals.shape[1])) for _ in range(2))
    there = np.zeros((OCTAVES, 1))
    squares = stretches.squares(residuals)
    for (a, b), heard, own in zip(pairwise(stretches.starts), squares, taken, strict=True):
        octaves, seen = _octaves(b - a), float(stretches.seen[a:b].mean())
        around = uniform_filter1d(own, NEIGHBOURS, axis=0) / max(seen, 1 / (b - a))
        found += octaves @ heard
        left += octaves @ np.maximum(1 - around, 0.0) * seen
        there += octaves.sum(axis=1, keepdims=True) * seen
    telling = left > LEAST_LEFT * np.maximum(there, 1e-12)
    return np.stack([_filled(*own) for own in zip(found.T, left.T, telling.T, strict=True)], axis=1)


def _filled(
    found: Float[ndarray, " octaves"],
    left: Float[ndarray, " octaves"],
    telling: Bool[ndarray, " octaves"],
) -> Float[ndarray, " octaves"]:
    """Squares found over the share left, where it tells; elsewhere as next to it."""
    if not telling.any():  # then nothing says which noise is louder
        return np.full(OCTAVES, found.sum() / max(float(left.sum()), 1.0))
    known = np.flatnonzero(telling)
    return np.interp(np.arange(OCTAVES), known, found[known] / left[known])


def noise_along(
    power: Float[ndarray, "octaves fits"],
    taken: Sequence[Float[ndarray, "_ fits"]],
    stretches: Stretches,
) -> Float[ndarray, " fits"]:
    """Squares of the noise that each of several fits takes.

    Args:
        power: Of the noise of each, as of `Colour`.
        taken: Its share, of each recording.
        stretches: Where they look.
    """
    pairs = zip(pairwise(stretches.starts), taken, strict=True)
    return np.sum(power * sum(_octaves(b - a) @ own for (a, b), own in pairs), axis=0)


@lru_cache(maxsize=REMEMBERED)
def _octaves(rows: int) -> Float[ndarray, "octaves frequencies"]:
    """How many frequencies of `fft` each of `rfft` stands for, in the row of its octave."""
    frequency = np.fft.rfftfreq(rows)
    slowest = 2.0 ** -(OCTAVES + 1)
    octave = OCTAVES + np.floor(np.log2(np.maximum(frequency, slowest) / 0.5)).astype(int)
    both = np.full(len(frequency), 2.0)
    both[0] = 1.0
    if rows % 2 == 0:
        both[-1] = 1.0
    return both * (np.clip(octave, 0, OCTAVES - 1) == np.arange(OCTAVES)[:, None])
