"""Intervals of estimates that are quoted only where they are large, as beside a standard deviation.

Of many parameters that are nearly zero a few look large by chance. If these alone are quoted, their
ordinary intervals hold the truth far less often than they say: of a parameter that is zero, and quoted
from two deviations on, never. Given that an estimate was quoted its distribution is a truncated one, whose
quantiles are known (Lee, Sun, Sun and Taylor 2016, "Exact post-selection inference", Annals of Statistics
44(3); Zhong and Prentice 2008, Biostatistics 9(4)).
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy import stats

HALVINGS = 60  # of the range in which a bound lies
WIDEST = 20.0  # standard deviations below an estimate, beyond which no bound is looked for


def lower_bounds(
    size: Float[ndarray, " p"],
    quoted_from: float,
    freedom: Float[ndarray, " p"],
    level: float,
) -> Float[ndarray, " p"]:
    """Lower ends of two-sided intervals of the truth, given that an estimate was quoted.

    Args:
        size: |estimate| in standard deviations, at least `quoted_from`.
        quoted_from: Least size that is quoted, of either sign.
        freedom: Of Student's t.
        level: Of the interval.

    Returns:
        (p,) in standard deviations, with the sign that the estimate has; no more than the ordinary end.
    """
    tail = (1 - level) / 2
    ordinary = size - stats.t.ppf(1 - tail, freedom)
    low, high = size - WIDEST, size.copy()
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        above = stats.t.sf(size - middle, freedom)
        quoted = stats.t.sf(quoted_from - middle, freedom) + stats.t.cdf(
            -quoted_from - middle, freedom
        )
        # The farther the truth, the likelier an estimate as large as this among those quoted.
        is_below = above < tail * quoted
        low, high = np.where(is_below, middle, low), np.where(is_below, high, middle)
    return np.minimum(low, ordinary)
