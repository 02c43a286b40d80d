"""Time stamps in whole nanoseconds as seconds that lose none of them."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

DAY = 86_400 * 10**9  # [ns]


def seconds_of_day(stamps: Int[ndarray, " samples"]) -> Float[ndarray, " samples"]:
    """Nanoseconds since any epoch as seconds since the first stamp's midnight [s].

    Counted from 1970 in floating point, time would have steps of 0.24 microseconds. Logs of one day
    stay on one clock.
    """
    stamps = np.asarray(stamps, dtype=np.int64)
    midnight = stamps[0] // DAY * DAY if len(stamps) else 0
    return (stamps - midnight) / 1e9
