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
from scipy import fft
from scipy.signal import welch

RESOLUTION = 4.0  # [s] of a stretch whose spectra are averaged


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
    share = np.clip(1 - heard / np.maximum(power, np.finfo(float).tiny), 0.0, 1.0)
    # Mirrored about both ends, so that nothing leaps there.
    long = fft.next_fast_len(3 * length, real=True)
    gain = np.interp(fft.rfftfreq(long, 1 / rate), frequency, share)
    result = []
    for signal in signals:
        padded = np.pad(signal, (length - 1, 0), mode="reflect", reflect_type="odd")
        padded = np.pad(padded, (0, long - len(padded)), mode="reflect", reflect_type="odd")
        kept = fft.irfft(fft.rfft(padded) * gain, long)
        result.append(kept[length - 1 : 2 * length - 1])
    return result
