"""Least squares with a prior on torque equations that are linear about an estimate.

Gauss and Newton; the joints' variances are those of the residuals; the covariance is the default one
of every estimate here, which counts coloured residuals for what they tell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.covariance import estimate_covariance
from oed.estimation.feasible.data_factor import JointFactors
from oed.estimation.load.torque_equations import TorqueEquations
from oed.estimation.noise import whiten
from oed.estimation.prior import Prior
from oed.estimation.triangular import add_prior, solve

# Steps until nothing moves by a hundredth of its standard deviation: three on every arm tried.
STEPS = 10
SETTLED = 0.01
# Estimates and variances, each from the other: a per cent is settled after three.
REWEIGHTINGS = 5


@dataclass(frozen=True)
class Fit:
    """An estimate of x, with what it rests on.

    Attributes:
        parameters: (x,).
        covariance: (x, x).
        degrees_of_freedom: (x,) of each one's Student-t interval.
        residual: (N, n) measured less modelled torque [N m].
        variances: (n,) of the residuals, which weigh the joints [N^2 m^2].
    """

    parameters: Float[ndarray, " x"]
    covariance: Float[ndarray, "x x"]
    degrees_of_freedom: Float[ndarray, " x"]
    residual: Float[ndarray, "samples joints"]
    variances: Float[ndarray, " joints"]


def fit(equations: TorqueEquations, prior: Prior) -> Fit:
    """Estimate what recordings and a prior determine.

    Args:
        equations: Of the recordings.
        prior: Of all of x, so that every direction has a value.
    """
    rows, torque = equations.linearised(prior.mean)
    before, (at, variances, factor) = prior.mean, _weighted(rows, torque, prior)
    joints = equations.torque.shape[1]
    for _ in range(STEPS - 1):
        if np.all(np.abs(factor @ (at - before)) <= SETTLED):
            break
        rows, torque = equations.linearised(at)
        before, (at, variances, factor) = at, _weighted(rows, torque, prior)
    residual = torque - (rows @ at).reshape(torque.shape)
    spread = estimate_covariance(
        whiten(rows, variances, joints),
        whiten(residual.reshape(-1), variances, joints).reshape(-1, joints),
        factor,
        segments=equations.segments,
    )
    return Fit(at, spread.covariance, spread.degrees_of_freedom, residual, variances)


def _weighted(
    rows: Float[ndarray, "rows x"], torque: Float[ndarray, "samples joints"], prior: Prior
) -> tuple[Float[ndarray, " x"], Float[ndarray, " joints"], Float[ndarray, "x x"]]:
    """The linear problem's solution, its variances and the factor of its information."""
    data = JointFactors.of(rows.reshape(*torque.shape, -1), torque)
    variances = data.variances(np.zeros(rows.shape[1]))
    for _ in range(REWEIGHTINGS):
        posterior = add_prior(data.weighted(variances).triangle, prior)
        found = solve(posterior)
        variances = data.variances(found)
    posterior = add_prior(data.weighted(variances).triangle, prior)
    return solve(posterior), variances, posterior[:-1, :-1]
