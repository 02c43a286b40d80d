"""Torque variances: from repetitions where there are any, else from residuals."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.least_squares import batch_least_squares
from oed.estimation.noise import whiten
from oed.estimation.prior import Prior
from oed.estimation.triangular import Solution, invert


def variances_from_repetitions(
    torque: Float[ndarray, "repetitions samples joints"],
) -> Float[ndarray, " joints"]:
    """Torque variance of each joint over M repetitions of one motion [N^2 m^2].

    Calafiore 2001, section 4: sigma_i^2 = sum_k sum_j (tau_ij(k) - mean_i(k))^2 / (n_m (M - 1)).
    It holds what differs between repetitions and nothing that repeats with the motion, so
    a model error is not in it.

    Raises:
        ValueError: If there are fewer than two repetitions.
    """
    return np.diag(covariance_from_repetitions(torque)).copy()


def covariance_from_repetitions(
    torque: Float[ndarray, "repetitions samples joints"],
) -> Float[ndarray, "joints joints"]:
    """Covariance (n, n) of the joints within a sample, over repetitions [N^2 m^2].

    Raises:
        ValueError: If there are fewer than two repetitions.
    """
    repetitions, samples, _ = torque.shape
    if repetitions < 2:
        raise ValueError(f"{repetitions=}: a variance needs at least two")
    deviation = torque - torque.mean(axis=0)
    return np.einsum("mki,mkj->ij", deviation, deviation) / (samples * (repetitions - 1))


def variances_from_residuals(
    regressor: Float[ndarray, "rows p"],
    torque: Float[ndarray, " rows"],
    joints: int,
    *,
    prior: Prior | None = None,
    tolerance: float = 1e-6,
    iterations: int = 100,
) -> Float[ndarray, " joints"]:
    """Torque variance of each joint from the residuals it weights [N^2 m^2].

    Estimate and variances are iterated to a fixed point. Each joint's sum of squares is
    divided by its samples less the parameters that its own rows determine (the trace of
    its block of the hat matrix), so that a joint which determines many is not flattered.

    Raises:
        ValueError: If shapes disagree or a joint has no degree of freedom left.
        NotIdentifiable: If the rows leave a direction undetermined.
    """
    solution = batch_least_squares(regressor, torque, joints, prior=prior)
    variances = _floored(solution.squares / (len(torque) / joints), torque, joints)
    for _ in range(iterations):
        solution = batch_least_squares(regressor, torque, joints, noise=variances, prior=prior)
        shares = parameter_shares(whiten(regressor, variances, joints), solution, joints)
        squares = np.sum((torque - regressor @ solution.parameters).reshape(-1, joints) ** 2, 0)
        before = variances
        variances = _floored(
            updated_variances(squares, len(torque) // joints, shares), torque, joints
        )
        if np.all(np.abs(variances - before) <= tolerance * before):
            break
    return variances


def covariance_from_residuals(
    regressor: Float[ndarray, "rows p"],
    torque: Float[ndarray, " rows"],
    joints: int,
    *,
    prior: Prior | None = None,
) -> Float[ndarray, "joints joints"]:
    """Covariance (n, n) of the joints within a sample, from residuals [N^2 m^2].

    The variances are those of `variances_from_residuals`, the correlations those of the
    residuals that they weight.

    Raises:
        ValueError: If shapes disagree or a joint has no degree of freedom left.
        NotIdentifiable: If the rows leave a direction undetermined.
    """
    variances = variances_from_residuals(regressor, torque, joints, prior=prior)
    solution = batch_least_squares(regressor, torque, joints, noise=variances, prior=prior)
    residual = (torque - regressor @ solution.parameters).reshape(-1, joints)
    products = residual.T @ residual
    lengths = np.sqrt(np.diag(products))
    return products / np.outer(lengths, lengths) * np.sqrt(np.outer(variances, variances))


def parameter_shares(
    white_regressor: Float[ndarray, "rows p"], solution: Solution, joints: int
) -> Float[ndarray, " joints"]:
    """How many of the parameters each joint's rows determine; they add up to p less the prior."""
    influence = white_regressor @ invert(solution.posterior_factor)
    return np.sum(influence.reshape(-1, joints, influence.shape[1]) ** 2, axis=(0, 2))


def updated_variances(
    squares: Float[ndarray, " joints"], samples: int, shares: Float[ndarray, " joints"]
) -> Float[ndarray, " joints"]:
    """Unbiased variances from residual sums of squares.

    Raises:
        ValueError: If a joint has no degree of freedom left.
    """
    left = samples - shares
    if not np.all(left > 0.5):
        joint = int(np.argmin(left))
        raise ValueError(
            f"joint {joint + 1} has {samples} samples for {shares[joint]:.1f} parameters: "
            "no degree of freedom is left for its variance"
        )
    return squares / left


def _floored(
    variances: Float[ndarray, " joints"], torque: Float[ndarray, " rows"], joints: int
) -> Float[ndarray, " joints"]:
    # A joint fitted to rounding would get an infinite weight: rounding of its own torque
    # is the least error that a residual can mean.
    scale = np.mean(torque.reshape(-1, joints) ** 2, axis=0)
    least = np.finfo(float).eps ** 2 * np.where(scale > 0, scale, 1.0)
    return np.maximum(variances, least)
