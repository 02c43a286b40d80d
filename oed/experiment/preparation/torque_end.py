"""Where a logged torque ends in frequency: beyond it someone has filtered it away.

A model's columns hold friction's steps at all frequencies. Against a torque that was low-passed before
it was logged they would be wrong there, and rows that depend on one another would pass for many.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import welch

# Of the largest amplitude density: no torque sensor resolves less, so an unfiltered log's noise is above.
LEAST_AMPLITUDE = 1e-3
SEGMENT = 4.0  # [s] of a spectrum: lines of slow motion are told apart from what is beyond them
# Its side lobes are 92 dB down (Harris 1978, Proc. IEEE 66(1)), below the amplitude that is looked for.
WINDOW = "blackmanharris"


def torque_end(torques: Sequence[Float[ndarray, "_ joints"]], rate: float) -> float:
    """Frequency beyond which no joint's torque has a thousandth of its largest amplitude density [Hz].

    Args:
        torques: Uniformly sampled, one array a stretch [N m or N].
        rate: [Hz].
    """
    length = min(int(SEGMENT * rate), *(len(torque) for torque in torques))
    spectra = [
        welch(torque, fs=rate, nperseg=length, axis=0, detrend="constant", window=WINDOW)
        for torque in torques
    ]
    frequency = spectra[0][0]
    density = np.mean([each for _, each in spectra], axis=0)
    present = density > LEAST_AMPLITUDE**2 * density.max(axis=0)
    return float(max(frequency[present.any(axis=1)], default=rate / 2))
