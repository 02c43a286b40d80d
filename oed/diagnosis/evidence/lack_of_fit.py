"""How much is left, against what floor, and whether the two differ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import f as f_distribution

from oed.diagnosis_new.noise.linear_fit import LinearFit


@dataclass(frozen=True)
class LackOfFit:
    """Residual of each joint against pure error, in white units.

    Attributes:
        ratio: (n,) root of mean squared white residual over pure error: 1 at the floor.
        p_value: (n,) of the F test that both are noise.
    """

    ratio: Float[ndarray, " joints"]
    p_value: Float[ndarray, " joints"]


def lack_of_fit(fit: LinearFit, noise_freedom: Float[ndarray, " joints"]) -> LackOfFit:
    """The lack-of-fit F test on whitened rows.

    Rows near reversals weigh less than their pure error would ask for, so the level of the
    test is at most its nominal one.

    Args:
        fit: On mean repetitions where there are any.
        noise_freedom: (n,) degrees of freedom that each joint's noise was estimated with.
    """
    freedom = fit.freedom()
    mean_square = np.sum(fit.residual**2, axis=1) / freedom
    p_value = f_distribution.sf(mean_square, freedom, noise_freedom)
    return LackOfFit(np.sqrt(mean_square), p_value)


def foretold_error(
    inverse: Float[ndarray, "parameters rank"],
    white: Float[ndarray, "joints rows base"],
    counted: Float[ndarray, " joints"],
) -> Float[ndarray, " joints"]:
    """Root of mean squared error that noise lets expect of another motion, in noise floors.

    Its own noise, and what the noise of the fitted motion made of the base parameters.

    Args:
        inverse: Of the fit's projection; its first parameters are the base model's.
        white: White base columns of the other motion.
        counted: (n,) its rows that count.
    """
    spread = np.sum((white @ inverse[: white.shape[2]]) ** 2, axis=(1, 2))
    return np.sqrt(1 + spread / counted)
