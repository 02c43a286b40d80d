"""Torque variances: from repetitions where there are any, else from residuals."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.least_squares import stacked
from oed.estimation.prior import Prior
from oed.estimation.row_pieces import RowPieces
from oed.estimation.streaming import StreamingLeastSquares


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
    regressor: Float[ndarray, "rows p"] | RowPieces,
    torque: Float[ndarray, " rows"],
    joints: int,
    *,
    prior: Prior | None = None,
    tolerance: float = 1e-6,
    iterations: int = 100,
) -> Float[ndarray, " joints"]:
    """Torque variance of each joint from the residuals it weights [N^2 m^2].

    As `StreamingLeastSquares.solve_with_residual_variances` finds them.

    Raises:
        ValueError: If shapes disagree or a joint has no degree of freedom left.
        NotIdentifiable: If the rows leave a direction undetermined.
    """
    pieces = stacked(regressor, torque, joints)
    seen = StreamingLeastSquares.of(pieces, torque)
    return seen.solve_with_residual_variances(prior, tolerance=tolerance, iterations=iterations)[1]
