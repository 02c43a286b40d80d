"""Estimated parameters with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy import stats

from oed.estimation.quoted_interval import lower_bounds


@dataclass(frozen=True)
class Estimate:
    """What the data say of the parameters of a torque model.

    Attributes:
        names: (p,) parameters, or readable combinations where only those are determined.
        units: (p,).
        parameters: (p,) xi-hat, in the units.
        covariance: (p, p) by the method named in `method`.
        information_factor: (p, p) upper triangular R of the weighted data, without the prior:
            Lambda = R^T R, so J_k = cond(R)^2 and J_d = 2 sum log |r_ii|.
        residual: (N, n) measured less modelled torque [N m].
        degrees_of_freedom: Torque equations less parameters.
        effective_degrees_of_freedom: (p,) of each parameter's Student-t interval; fewer than
            `degrees_of_freedom` where residuals are coloured.
        joint_variances: (n,) residual variances that weighted the joints [N^2 m^2].
        status: "determined", or "reduced" if only combinations of the columns are determined.
        method: Estimator, weights and covariance in words.
        unidentifiable: Names without a value, both those removed and those too badly excited.
        reasons: One sentence for each of them.
        columns: (p,) indices of the regressor's columns that the parameters multiply.
        reach: (p,) how far an unseen error reaches along each direction of the parameters, as
            `oed.estimation.reach`, largest first; those beyond 1 are left at zero.
        quoted_from: Standard deviations from zero from which on a parameter is quoted, which its
            interval knows; 0 where all are.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    parameters: Float[ndarray, " p"]
    covariance: Float[ndarray, "p p"]
    information_factor: Float[ndarray, "p p"]
    residual: Float[ndarray, "samples joints"]
    degrees_of_freedom: float
    effective_degrees_of_freedom: Float[ndarray, " p"]
    joint_variances: Float[ndarray, " joints"]
    status: str
    method: str
    unidentifiable: tuple[str, ...]
    reasons: tuple[str, ...]
    columns: tuple[int, ...]
    reach: Float[ndarray, " p"]
    quoted_from: float = 0.0

    def __post_init__(self) -> None:
        counts = (len(self.names), len(self.units), len(self.columns), len(self.parameters))
        if len(set(counts)) > 1:
            raise ValueError(f"names, units, columns and parameters number {counts}")
        if len(self.unidentifiable) != len(self.reasons):
            raise ValueError(
                f"{len(self.unidentifiable)} unidentifiable names, {len(self.reasons)} reasons"
            )

    @property
    def std(self) -> Float[ndarray, " p"]:
        """Standard deviation of each parameter, in its unit."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def relative_std(self) -> Float[ndarray, " p"]:
        """Standard deviation per absolute value; inf where the value is zero."""
        size = np.abs(self.parameters)
        return np.divide(self.std, size, out=np.full_like(size, np.inf), where=size > 0)

    @property
    def determined(self) -> Bool[ndarray, " p"]:
        """False for a badly excited parameter, whose value predicts but is not to be quoted."""
        return np.array([name not in self.unidentifiable for name in self.names], dtype=bool)

    @property
    def correlation(self) -> Float[ndarray, "p p"]:
        """Correlation matrix of the errors."""
        return self.covariance / np.outer(self.std, self.std)

    def interval(self, level: float = 0.95) -> Float[ndarray, "p 2"]:
        """Two-sided Student-t intervals [lower, upper] at a confidence level.

        Of a parameter that is quoted because it is large, the end towards zero is that of the
        estimates that are quoted (`oed.estimation.quoted_interval`).

        Raises:
            ValueError: If the level is not between 0 and 1.
        """
        if not 0 < level < 1:
            raise ValueError(f"{level=} must lie between 0 and 1")
        freedom = self.effective_degrees_of_freedom
        reach = stats.t.ppf(0.5 + level / 2, freedom) * self.std
        ends = np.column_stack([self.parameters - reach, self.parameters + reach])
        size = np.abs(self.parameters) / np.where(self.std > 0, self.std, np.inf)
        quoted = self.determined & (size >= self.quoted_from) & (self.std > 0)
        if self.quoted_from and quoted.any():
            lower = lower_bounds(size[quoted], self.quoted_from, freedom[quoted], level)
            sign = np.sign(self.parameters[quoted])
            end = np.where(sign > 0, 0, 1)
            ends[np.flatnonzero(quoted), end] = sign * lower * self.std[quoted]
        return ends

    def predict(self, regressor: Float[ndarray, "rows all"]) -> Float[ndarray, " rows"]:
        """Torque for the full regressor, before any column was removed [N m]."""
        return regressor[:, list(self.columns)] @ self.parameters
