"""Zero-phase low-pass: a Butterworth filter run forward and backward."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import butter, sosfiltfilt

PADDING = 3.0  # periods of the cut-off reflected at each end: the filter has settled by then


def lowpass(
    x: Float[ndarray, " samples *columns"], rate: float, cutoff: float, order: int = 4
) -> Float[ndarray, " samples *columns"]:
    """Low-pass along the first axis without shifting phase.

    Two passes square the gain: at `cutoff` it is 1/2 (-6 dB), not -3 dB, and the
    attenuation is that of order 2 `order`. `cutoff` is not corrected for this; the frequency
    of half power is `half_power_frequency(cutoff, order)`. Ends are continued by point
    reflection (Gustafsson, "Determining the initial states in forward-backward filtering",
    IEEE Trans. Signal Processing 44(4), 1996, discusses the alternatives), so the first and
    last period of the cut-off should be trimmed.

    Args:
        x: (N, ...) samples on a uniform grid, any unit.
        rate: Sampling rate [Hz].
        cutoff: Cut-off of the one-way Butterworth filter [Hz], below rate / 2.
        order: Order of the one-way filter.

    Raises:
        ValueError: If `cutoff` is not between 0 and rate / 2, or N < 4.
    """
    if not 0 < cutoff < rate / 2:
        raise ValueError(f"cut-off {cutoff:g} Hz must lie between 0 and half of {rate:g} Hz")
    if order < 1:
        raise ValueError(f"order {order} must be at least 1")
    if len(x) < 4:
        raise ValueError(f"{len(x)} samples are too few to filter; at least 4")
    sections = butter(order, cutoff, fs=rate, output="sos")
    padding = min(len(x) - 1, int(np.ceil(PADDING * rate / cutoff)))
    return sosfiltfilt(sections, x, axis=0, padtype="odd", padlen=padding)


def half_power_frequency(cutoff: float, order: int = 4) -> float:
    """Frequency [Hz] at which `lowpass` halves the power (-3 dB).

    From the squared gain 1 / (1 + (f/fc)^(2 order)) of two passes set to 1/sqrt(2); exact
    for cut-offs far below the sampling rate, where the bilinear transform bends nothing.
    """
    return float(cutoff * (np.sqrt(2) - 1) ** (1 / (2 * order)))
