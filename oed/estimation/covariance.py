"""Covariance of the estimate when residuals are correlated in time and between joints.

Torques are low-pass filtered and then decimated, and what the model lacks follows the
motion, so the residual of one sample resembles the next. P of (8) counts every sample as
new information and is then too small. With Q = A R^-1 for whitened rows A and the factor R
of the posterior information, the covariance of the estimate is

    V = R^-1 (Q^T Omega Q + prior share) R^-T,      Omega = covariance of the noise,

and the methods differ in how they learn Q^T Omega Q from residuals.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.autoregressive import mix_joints
from oed.estimation.autoregressive_fit import fit_autoregressive_noise
from oed.estimation.effective_samples import effective_degrees_of_freedom
from oed.estimation.row_pieces import RowPieces
from oed.estimation.triangular import invert

CovarianceMethod = Literal["hac", "white", "newey_west", "prewhitened"]

# Andrews & Monahan 1992, section 3: keeps the recolouring factor finite.
LARGEST_PREWHITENING = 0.97

_TEXT = {
    "hac": "joint-wise autoregressive residuals with bias correction",
    "white": "white residuals",
    "newey_west": "Newey-West, Bartlett kernel, bandwidth by Andrews 1991",
    "prewhitened": "Newey-West on prewhitened scores, Andrews and Monahan 1992",
}


@dataclass(frozen=True)
class CovarianceEstimate:
    """Covariance of an estimate and how well it is known.

    Attributes:
        covariance: (p, p).
        degrees_of_freedom: (p,) of the Student-t distribution of each parameter's error
            divided by its standard deviation.
        text: The method in words.
    """

    covariance: Float[ndarray, "p p"]
    degrees_of_freedom: Float[ndarray, " p"]
    text: str


def estimate_covariance(
    white_regressor: Float[ndarray, "rows p"] | RowPieces,
    white_residual: Float[ndarray, "samples joints"],
    posterior_factor: Float[ndarray, "p p"],
    *,
    method: CovarianceMethod = "hac",
    segments: tuple[int, ...] | None = None,
) -> CovarianceEstimate:
    """Covariance of the weighted least-squares estimate.

    "hac" (the default) models the residual of each joint as autoregressive, undoes the loss
    of colour that fitting causes, and allows for the noise model's own uncertainty by
    Student-t degrees of freedom. "newey_west" and "prewhitened" are the kernel estimators of
    econometrics, kept for comparison: with a few dozen correlated samples a parameter they
    cover clearly less (studies/coverage.py). "white" is (8), scaled by the residual variance.

    Args:
        white_regressor: A, rows divided by the noise's standard deviation (see `whiten`): an array,
            or a piece for each segment.
        white_residual: (N, n), whitened likewise.
        posterior_factor: R with R^T R = A^T A + prior information.
        method: See above.
        segments: Samples of each recording in the stack; correlation never crosses from one
            to the next. None is one recording, or those that the pieces are.

    Raises:
        ValueError: If the segments do not add up to N, or no degree of freedom is left.
    """
    samples, joints = white_residual.shape
    pieces = RowPieces.of(white_regressor, joints, segments)
    root = invert(posterior_factor)
    influence = pieces.times(root)
    gram = sum((flat.T @ flat for flat in influence), np.zeros_like(root))
    left = samples * joints - np.trace(gram)
    if not left >= 1:
        raise ValueError(f"{samples * joints} rows leave {left:.1f} degrees of freedom")
    # What the prior adds to the information has unit covariance by definition.
    prior_share = np.eye(len(gram)) - gram
    if method == "hac":
        noise = fit_autoregressive_noise(influence, white_residual)
        scores = (_gram(noise.adjoint_filter(Q), noise.innovation) for Q in influence.influences())
        meat = sum(scores, np.zeros_like(root))
        freedom = effective_degrees_of_freedom(influence, root, noise)
    elif method == "white":
        meat = gram * np.sum(white_residual**2) / left
        freedom = np.full(len(gram), float(left))
    else:
        meat = _kernel_meat(influence, white_residual, method) * samples * joints / left
        freedom = np.full(len(gram), float(left))
    covariance = root @ (meat + prior_share) @ root.T
    return CovarianceEstimate((covariance + covariance.T) / 2, freedom, _TEXT[method])


def _gram(
    signals: Float[ndarray, "samples joints p"], innovation: Float[ndarray, "joints joints"]
) -> Float[ndarray, "p p"]:
    mixed = mix_joints(np.linalg.cholesky(innovation).T, signals)
    flat = mixed.reshape(-1, mixed.shape[2])
    return flat.T @ flat


def _kernel_meat(
    influence: RowPieces,
    residual: Float[ndarray, "samples joints"],
    method: CovarianceMethod,
) -> Float[ndarray, "p p"]:
    own = np.split(residual, np.cumsum(influence.lengths)[:-1])
    pairs = zip(influence.influences(), own, strict=True)
    parts = [np.einsum("kjp,kj->kp", Q, u) for Q, u in pairs]
    if method == "newey_west":
        return _bartlett(parts)
    slopes = np.clip(_lag_one(parts), -LARGEST_PREWHITENING, LARGEST_PREWHITENING)
    meat = _bartlett([np.vstack([part[:1], part[1:] - slopes * part[:-1]]) for part in parts])
    return meat / np.outer(1 - slopes, 1 - slopes)


def _lag_one(parts: list[ndarray]) -> Float[ndarray, " p"]:
    products = sum(np.sum(part[1:] * part[:-1], axis=0) for part in parts)
    squares = sum(np.sum(part**2, axis=0) for part in parts)
    return products / np.where(squares > 0, squares, 1.0)


def _bartlett(parts: list[ndarray]) -> Float[ndarray, "p p"]:
    samples = sum(len(part) for part in parts)
    slopes = np.clip(_lag_one(parts), -LARGEST_PREWHITENING, LARGEST_PREWHITENING)
    innovation = sum(np.sum(part**2, axis=0) for part in parts) * (1 - slopes**2)
    # Andrews 1991, (6.2) and (6.4), an AR(1) for every score with equal weights.
    scale = np.sum(innovation**2 / (1 - slopes) ** 4)
    curvature = np.sum(4 * slopes**2 * innovation**2 / ((1 - slopes) ** 6 * (1 + slopes) ** 2)) / (
        scale if scale > 0 else 1.0
    )
    bandwidth = 1.1447 * (curvature * samples) ** (1 / 3)
    meat = np.sum([part.T @ part for part in parts], axis=0)
    for lag in range(1, min(int(np.ceil(bandwidth)), max(len(part) for part in parts))):
        lagged = np.sum([part[lag:].T @ part[:-lag] for part in parts if len(part) > lag], axis=0)
        meat += (1 - lag / bandwidth) * (lagged + lagged.T)
    return meat
