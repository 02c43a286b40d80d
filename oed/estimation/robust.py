"""Least squares that single outliers cannot move: M-estimation by reweighting.

Huber and Ronchetti, Robust Statistics, 2nd ed. 2009, chapter 7; Maronna, Martin, Yohai,
Robust Statistics, 2006, chapters 2 and 4.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.errors import OedError
from oed.estimation.least_squares import batch_least_squares, stacked
from oed.estimation.noise import whitened
from oed.estimation.prior import Prior
from oed.estimation.row_pieces import RowPieces
from oed.estimation.triangular import Solution
from oed.estimation.weights import variances_from_residuals

RobustLoss = Literal["huber", "tukey"]

# 95 % efficiency at the normal distribution (Maronna et al., sections 2.2 and 2.3).
TUNING = {"huber": 1.345, "tukey": 4.685}
# Median absolute deviation of the standard normal distribution.
NORMAL_MAD = 0.6744897501960817


class RobustNotConverged(OedError):
    """The reweighting has not settled.

    Attributes:
        change: Last largest change of a parameter, in its standard deviations.
    """

    def __init__(self, message: str, change: float) -> None:
        super().__init__(message)
        self.change = change


@dataclass(frozen=True)
class RobustSolution:
    """An M-estimate, and the linear problem that its error behaves as.

    To first order xi-hat - xi = (A^T A)^-1 A^T u with the rows A and the residual u below,
    so that any covariance for least squares holds for it (Huber & Ronchetti, section 7.6).

    Attributes:
        solution: Parameters and factors of the pseudo-rows A.
        weights: (N, n) of the last reweighting, 1 where a row counts in full.
        variances: (n,) robust residual variances of the joints [N^2 m^2].
        pseudo_regressor: A, (rows, p) in pieces.
        pseudo_residual: (N, n) u.
    """

    solution: Solution
    weights: Float[ndarray, "samples joints"]
    variances: Float[ndarray, " joints"]
    pseudo_regressor: RowPieces
    pseudo_residual: Float[ndarray, "samples joints"]


def robust_least_squares(
    regressor: Float[ndarray, "rows p"] | RowPieces,
    torque: Float[ndarray, " rows"],
    joints: int,
    *,
    loss: RobustLoss = "huber",
    prior: Prior | None = None,
    tolerance: float = 1e-8,
    iterations: int = 500,
) -> RobustSolution:
    """M-estimate with the scale of each joint from the median absolute residual.

    The Huber loss is convex and bounds what one row can do; the Tukey loss ignores gross
    outliers altogether and is started from the Huber estimate with its scale held, since it
    has local minima.

    Args:
        regressor: H, sample-major; an array, or in pieces.
        torque: y [N m].
        joints: n.
        loss: "huber" or "tukey", both tuned to 95 % efficiency at normal noise.
        prior: As in `batch_least_squares`.
        tolerance: Largest change of a parameter in standard deviations that counts as settled.
        iterations: Most reweightings.

    Raises:
        ValueError: If shapes disagree.
        NotIdentifiable: If the rows with weight leave a direction undetermined.
        RobustNotConverged: If the reweighting does not settle.
    """
    regressor = stacked(regressor, torque, joints)
    problem = _Problem(regressor, torque, joints, prior, tolerance, iterations)
    variances = variances_from_residuals(regressor, torque, joints, prior=prior)
    start = batch_least_squares(regressor, torque, joints, noise=variances, prior=prior)
    parameters, deviations = _reweight(problem, "huber", start.parameters)
    if loss == "tukey":
        parameters, deviations = _reweight(problem, loss, parameters, held=deviations)
    return _linearise(problem, loss, parameters, deviations)


@dataclass(frozen=True)
class _Problem:
    regressor: RowPieces
    torque: Float[ndarray, " rows"]
    joints: int
    prior: Prior | None
    tolerance: float
    iterations: int

    def residual(self, parameters: Float[ndarray, " p"]) -> Float[ndarray, "samples joints"]:
        return self.torque.reshape(-1, self.joints) - self.regressor.predict(parameters)


def _reweight(
    problem: _Problem,
    loss: RobustLoss,
    parameters: Float[ndarray, " p"],
    held: Float[ndarray, " joints"] | None = None,
) -> tuple[Float[ndarray, " p"], Float[ndarray, " joints"]]:
    change = np.inf
    for _ in range(problem.iterations):
        residual = problem.residual(parameters)
        deviations = _median_deviations(problem, residual) if held is None else held
        weights = _weights(residual / deviations, loss)
        # A row of weight zero is one of infinite variance: far beyond what counts.
        variances = deviations**2 / np.maximum(weights, 1e-12)
        solution = batch_least_squares(
            problem.regressor,
            problem.torque,
            problem.joints,
            noise=variances.reshape(-1),
            prior=problem.prior,
        )
        std = np.sqrt(np.diag(solution.covariance))
        change = float(np.max(np.abs(solution.parameters - parameters) / std))
        parameters = solution.parameters
        if change <= problem.tolerance:
            return parameters, deviations
    raise RobustNotConverged(
        f"{problem.iterations} reweightings with the {loss} loss; the last moved a parameter by "
        f"{change:.1e} of its standard deviation",
        change,
    )


def _linearise(
    problem: _Problem,
    loss: RobustLoss,
    parameters: Float[ndarray, " p"],
    deviations: Float[ndarray, " joints"],
) -> RobustSolution:
    standard = problem.residual(parameters) / deviations
    weights = _weights(standard, loss)
    slope = np.mean(_influence_slope(standard, loss), axis=0)
    if not np.all(slope > 0):
        raise RobustNotConverged("more than half of a joint's residuals are outliers", np.inf)
    variances = deviations**2 / slope
    pseudo_residual = weights * standard / np.sqrt(slope)
    pseudo_regressor = whitened(problem.regressor, variances)
    fitted = pseudo_regressor.predict(parameters) + pseudo_residual
    linear = batch_least_squares(
        pseudo_regressor, fitted.reshape(-1), problem.joints, prior=problem.prior
    )
    solution = Solution(
        parameters=parameters,
        information_factor=linear.information_factor,
        posterior_factor=linear.posterior_factor,
        squares=np.sum(pseudo_residual**2, axis=0),
        rows=len(problem.torque),
    )
    return RobustSolution(solution, weights, deviations**2, pseudo_regressor, pseudo_residual)


def _median_deviations(
    problem: _Problem, residual: Float[ndarray, "samples joints"]
) -> Float[ndarray, " joints"]:
    rows, parameters = problem.regressor.rows, problem.regressor.columns
    # Residuals of a fit are too small by the parameters it used, shared among the joints.
    shrinkage = np.sqrt(max(1 - parameters / rows, 1e-3))
    deviations = np.median(np.abs(residual), axis=0) / (NORMAL_MAD * shrinkage)
    floor = np.finfo(float).eps * np.sqrt(np.mean(problem.torque**2))
    return np.maximum(deviations, max(floor, np.finfo(float).tiny ** 0.5))


def _weights(standard: Float[ndarray, "samples joints"], loss: RobustLoss) -> ndarray:
    size = np.abs(standard) / TUNING[loss]
    if loss == "huber":
        return 1 / np.maximum(size, 1.0)
    return np.where(size < 1, (1 - np.minimum(size, 1.0) ** 2) ** 2, 0.0)


def _influence_slope(standard: Float[ndarray, "samples joints"], loss: RobustLoss) -> ndarray:
    square = (standard / TUNING[loss]) ** 2
    if loss == "huber":
        return (square < 1).astype(float)
    return np.where(square < 1, (1 - square) * (1 - 5 * square), 0.0)
