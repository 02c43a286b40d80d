"""How much is left, against what floor, and whether the two differ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import f as f_distribution

from oed.diagnosis.fit.linear_fit import LinearFit


@dataclass(frozen=True)
class LackOfFit:
    """Residual of each joint against pure error, in white units.

    Attributes:
        ratio: (n,) root of mean squared white residual over pure error: 1 at the floor.
        p_value: (n,) of the F test that both are noise.
        freedom: (n,) degrees of freedom of the residual.
    """

    ratio: Float[ndarray, " joints"]
    p_value: Float[ndarray, " joints"]
    freedom: Float[ndarray, " joints"]


def lack_of_fit(fit: LinearFit, noise_freedom: float) -> LackOfFit:
    """The lack-of-fit F test on whitened rows.

    Rows near reversals weigh less than their pure error would ask for, so the level of the
    test is at most its nominal one.

    Args:
        fit: On mean repetitions where there are any.
        noise_freedom: Rows that the noise was estimated from.
    """
    freedom = fit.freedom()
    mean_square = np.sum(fit.residual**2, axis=1) / freedom
    p_value = f_distribution.sf(mean_square, freedom, max(noise_freedom, 1.0))
    return LackOfFit(np.sqrt(mean_square), p_value, freedom)
