"""A signal held where it stands out of noise of known spectrum.

A torque that is worked out from a measured motion has the encoder's noise in it, differentiated
twice. What resonates with such a torque must be driven by what is expected of it, given what was
measured: each frequency keeps its share of signal (Wiener 1949, "Extrapolation, Interpolation, and
Smoothing of Stationary Time Series"; regression calibration in Carroll, Ruppert, Stefanski and
Crainiceanu 2006, "Measurement Error in Nonlinear Models", chapter 4).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.integrate import cumulative_trapezoid
from scipy.signal import welch

RESOLUTION = 4.0  # [s] of a stretch whose spectra are averaged
AROUND = 0.1  # of a frequency, on either side, over which they are: single ones scatter


def expected(
    signals: Sequence[Float[ndarray, " samples"]], rate: float, noise: float
) -> list[Float[ndarray, " samples"]]:
    """Signals that one noisy motion drives, each frequency times its share of the first's signal.

    Args:
        signals: The first decides what is noise.
        rate: [Hz].
        noise: One-sided spectral density of its second integral's noise, white
            [unit^2 s^4 / Hz].
    """
    length = len(signals[0])
    frequency, power = welch(signals[0], fs=rate, nperseg=min(length, round(RESOLUTION * rate)))
    heard = noise * (2 * np.pi * frequency) ** 4
    power, heard = (_around(frequency, x) for x in (power, heard))
    share = 1 - np.minimum(heard, power) / np.where(power > 0, power, 1.0)
    # Mirrored about both ends, so that nothing leaps there.
    long = 1 << (3 * length - 1).bit_length()
    gain = np.interp(np.fft.rfftfreq(long, 1 / rate), frequency, share)
    result = []
    for signal in signals:
        padded = np.pad(signal, (length - 1, 0), mode="reflect", reflect_type="odd")
        padded = np.pad(padded, (0, long - len(padded)), mode="reflect", reflect_type="odd")
        kept = np.fft.irfft(np.fft.rfft(padded) * gain, long)
        result.append(kept[length - 1 : 2 * length - 1])
    return result


def _around(
    frequency: Float[ndarray, " lines"], spectrum: Float[ndarray, " lines"]
) -> Float[ndarray, " lines"]:
    """Mean of a spectrum around each frequency, that at rest as it is."""
    total = cumulative_trapezoid(spectrum, frequency, initial=0.0)
    lower, upper = ((1 + side) * frequency for side in (-AROUND, AROUND))
    low, high = (np.interp(x, frequency, total) for x in (lower, upper))
    width = np.minimum(upper, frequency[-1]) - lower
    return np.where(width > 0, (high - low) / np.where(width > 0, width, 1.0), spectrum)
