"""How well a covariance from coloured residuals is itself known."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import solve, toeplitz

from oed.estimation.autoregressive import AutoregressiveNoise
from oed.estimation.row_pieces import RowPieces

LEAST_DEGREES_OF_FREEDOM = 2.0


def effective_degrees_of_freedom(
    influence: RowPieces,
    root: Float[ndarray, "p p"],
    noise: AutoregressiveNoise,
) -> Float[ndarray, " p"]:
    """Student-t degrees of freedom of each parameter, after Satterthwaite.

    A variance V with standard error s behaves as one from 2 V^2 / s^2 independent samples
    (Satterthwaite 1946; Kenward & Roger 1997 for fitted covariances). Here V is a sum over
    frequency of the squared influence of a parameter times the noise spectrum, and s follows
    from the asymptotic covariance of the autoregressive coefficients and of the innovation
    variance (Brockwell & Davis, theorem 8.1.1), joints taken as independent.

    Args:
        influence: Q, a piece for each of the independent recordings.
        root: R^-1.
        noise: The fitted noise.
    """
    count, samples = influence.columns, sum(influence.lengths)
    shares = np.zeros(influence.joints)
    variances = [np.zeros(count) for _ in noise.coefficients]
    slopes = [np.zeros((len(polynomial) - 1, count)) for polynomial in noise.coefficients]
    for Q in influence.influences():
        shares += np.sum(Q**2, axis=(0, 2))
        for joint, polynomial in enumerate(noise.coefficients):
            part, part_slope = _spectral_variance(
                Q[:, joint] @ root.T, polynomial, noise.innovation[joint, joint], noise.tail
            )
            variances[joint] += part
            slopes[joint] += part_slope
    total = np.zeros(count)
    error = np.zeros(count)
    for joint, (variance, slope) in enumerate(zip(variances, slopes, strict=True)):
        order = len(slope)
        left = max(samples - shares[joint] - order, 1.0)
        total += variance
        error += 2 * variance**2 / left
        if order:
            gamma = noise.autocovariance(order)[:, joint] / noise.innovation[joint, joint]
            error += np.sum(slope * solve(toeplitz(gamma), slope, assume_a="pos"), axis=0) / left
    freedom = 2 * total**2 / np.where(error > 0, error, 1.0)
    return np.maximum(np.where(error > 0, freedom, np.inf), LEAST_DEGREES_OF_FREEDOM)


def _spectral_variance(
    paths: Float[ndarray, "samples p"],
    polynomial: Float[ndarray, " order1"],
    innovation: float,
    tail: int,
) -> tuple[Float[ndarray, " p"], Float[ndarray, "order p"]]:
    """Variance that one joint's noise gives each parameter, and its slope in a_1 ... a_m."""
    points = 2 ** int(np.ceil(np.log2(len(paths) + tail)))
    power = np.abs(np.fft.rfft(paths, points, axis=0)) ** 2
    power[1:-1] *= 2
    transfer = 1 / np.fft.rfft(polynomial, points)
    weighted = power * (innovation * np.abs(transfer) ** 2 / points)[:, None]
    delays = np.exp(
        -2j * np.pi * np.outer(np.arange(1, len(polynomial)), np.arange(len(transfer))) / points
    )
    slope = -2 * np.real(delays * transfer) @ weighted
    return weighted.sum(axis=0), slope
