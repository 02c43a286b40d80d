"""What is known of the parameters before the data: mean and covariance of (7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import solve_triangular


@dataclass(frozen=True)
class Prior:
    """A Gaussian prior, kept as a square root of its information.

    Attributes:
        mean: (p,) the prior value of each parameter, in its unit.
        factor: (k, p) F with F^T F = R_xi^-1; no row at all is the flat prior R_xi = inf.
    """

    mean: Float[ndarray, " p"]
    factor: Float[ndarray, "k p"]

    @classmethod
    def flat(cls, parameters: int) -> Prior:
        """Nothing is known: R_xi = inf."""
        return cls(np.zeros(parameters), np.zeros((0, parameters)))

    @classmethod
    def gaussian(cls, mean: Float[ndarray, " p"], covariance: Float[ndarray, "p p"]) -> Prior:
        """Mean and full covariance R_xi.

        Raises:
            ValueError: If the covariance is not positive definite.
        """
        # Unit diagonal first: parameters of different units must not spoil the factor.
        scale = np.sqrt(np.diag(covariance))
        if not np.all(scale > 0):
            raise ValueError("a prior variance is not positive")
        try:
            lower = np.linalg.cholesky(covariance / np.outer(scale, scale))
        except np.linalg.LinAlgError as error:
            raise ValueError("the prior covariance is not positive definite") from error
        factor = solve_triangular(lower, np.eye(len(mean)), lower=True) / scale
        return cls(np.asarray(mean, dtype=float), factor)

    @classmethod
    def independent(cls, mean: Float[ndarray, " p"], std: Float[ndarray, " p"]) -> Prior:
        """Mean and standard deviation of each parameter; inf where nothing is known.

        Raises:
            ValueError: If a standard deviation is not positive.
        """
        if not np.all(std > 0):
            raise ValueError("a prior standard deviation is not positive")
        known = np.isfinite(std)
        return cls(np.asarray(mean, dtype=float), np.diag(1 / std)[known])

    @property
    def offset(self) -> Float[ndarray, " k"]:
        """Right-hand side F mean of the rows that the prior adds."""
        return self.factor @ self.mean
