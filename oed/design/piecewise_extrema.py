"""Proven extrema of piecewise polynomials from their Bernstein coefficients.

A polynomial on an interval lies between the least and the largest of its Bernstein coefficients,
and has the first and last as its end values. Halving an interval (de Casteljau) brings the two
together as the square of its length. G. Farin, "Curves and Surfaces for CAGD", chapter 5.
"""

from __future__ import annotations

from functools import lru_cache
from math import comb

import numpy as np
from jaxtyping import Float
from numpy import ndarray

HALVINGS = 50  # beyond which doubles cannot halve an interval any more


def bernstein_range(
    pieces: Float[ndarray, "pieces coefficients joints"], gap: Float[ndarray, " joints"]
) -> Float[ndarray, "joints 2"]:
    """Bounds that no piece leaves, at most `gap` beyond the extrema, rounding apart.

    Args:
        pieces: Bernstein coefficients of each piece.
        gap: How far bounds may lie beyond values that are attained.

    Returns:
        (n, 2) lower bound on the minimum and upper bound on the maximum.
    """
    ends = pieces[:, [0, -1]]
    attained = np.stack([ends.min(axis=(0, 1)), ends.max(axis=(0, 1))])
    proven, halves = attained.copy(), _halves(pieces.shape[1] - 1)
    for level in range(HALVINGS):
        lower, upper = pieces.min(axis=1), pieces.max(axis=1)
        is_open = ((lower < attained[0] - gap) | (upper > attained[1] + gap)).any(axis=1)
        if level == HALVINGS - 1:
            is_open[:] = False
        if not is_open.all():
            proven[0] = np.minimum(proven[0], lower[~is_open].min(axis=0))
            proven[1] = np.maximum(proven[1], upper[~is_open].max(axis=0))
        if not is_open.any():
            break
        pieces = np.concatenate(
            [np.einsum("cb,kbj->kcj", half, pieces[is_open]) for half in halves]
        )
        ends = pieces[:, [0, -1]]
        attained[0] = np.minimum(attained[0], ends.min(axis=(0, 1)))
        attained[1] = np.maximum(attained[1], ends.max(axis=(0, 1)))
    return proven.T.copy()


@lru_cache
def _halves(degree: int) -> tuple[Float[ndarray, "coefficients coefficients"], ...]:
    """Coefficients of the first and the second half of an interval by those of the whole."""
    first = np.array(
        [
            [comb(i, j) / 2**i if j <= i else 0.0 for j in range(degree + 1)]
            for i in range(degree + 1)
        ]
    )
    return first, first[::-1, ::-1].copy()
