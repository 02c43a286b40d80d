"""The torque noise R_v, and the whitening that turns weighted into ordinary least squares."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import solve_triangular

from oed.estimation.row_pieces import RowPieces

TorqueNoise = (
    Float[ndarray, " joints"] | Float[ndarray, " rows"] | Float[ndarray, "joints joints"] | None
)


def whiten(
    stacked: Float[ndarray, " rows *columns"],
    noise: TorqueNoise,
    joints: int,
) -> Float[ndarray, " rows *columns"]:
    """Scale stacked rows so that their noise has unit covariance.

    Args:
        stacked: Torques (rows,) [N m] or regressor (rows, p), sample-major: row k n + j
            is joint j at sample k.
        noise: R_v of (7): variances of the joints (n,) or of the rows (rows,) [N^2 m^2],
            the covariance (n, n) of the joints within a sample, or None for R_v = I.
        joints: n.

    Raises:
        ValueError: If the rows are no multiple of n, or the noise is not positive definite
            or of another shape.
    """
    rows = len(stacked)
    if rows % joints:
        raise ValueError(f"{rows=} is not a multiple of {joints=}")
    if noise is None:
        return np.array(stacked, dtype=float)
    if noise.shape == (joints, joints) and noise.ndim == 2:
        return _decorrelate(stacked, noise, joints)
    if noise.shape not in ((joints,), (rows,)):
        raise ValueError(f"noise has shape {noise.shape}, not ({joints},), ({rows},) or (n, n)")
    if not np.all((noise > 0) & np.isfinite(noise)):
        raise ValueError("every noise variance must be positive and finite")
    variances = noise if len(noise) == rows else np.tile(noise, rows // joints)
    return stacked / np.sqrt(variances).reshape(-1, *[1] * (stacked.ndim - 1))


def whitened(pieces: RowPieces, noise: TorqueNoise) -> RowPieces:
    """The rows of a regressor so scaled, in pieces as they come; `noise` as in `whiten`."""

    def scale(piece: Float[ndarray, "rows p"], place: slice) -> Float[ndarray, "rows p"]:
        each = noise is not None and noise.shape == (pieces.rows,) and len(noise) > pieces.joints
        return whiten(piece, noise[place] if noise is not None and each else noise, pieces.joints)

    return pieces.changed(scale, pieces.columns)


def _decorrelate(
    stacked: Float[ndarray, " rows *columns"],
    covariance: Float[ndarray, "joints joints"],
    joints: int,
) -> Float[ndarray, " rows *columns"]:
    try:
        lower = np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError as error:
        raise ValueError("the joint noise covariance is not positive definite") from error
    by_joint = np.moveaxis(stacked.reshape(-1, joints, *stacked.shape[1:]), 1, 0)
    white = solve_triangular(lower, by_joint.reshape(joints, -1), lower=True)
    return np.moveaxis(white.reshape(by_joint.shape), 0, 1).reshape(stacked.shape)
