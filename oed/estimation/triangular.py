"""The triangular factor that batch, recursive and streaming least squares share.

All three keep the upper triangular T of an orthogonal factorisation of the augmented
rows [A b] (Golub & Van Loan, Matrix Computations, section 5.3; Bierman 1977):

    T = [ R  z ]      R^T R = A^T A,   xi = R^-1 z,   rho^2 = |b - A xi|^2
        [ 0 rho]

A^T A itself is never formed, because that squares the condition number.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import get_lapack_funcs, solve_triangular

from oed.errors import OedError
from oed.estimation.prior import Prior

# Scaled to unit columns, a regressor computed in double precision shows an exact linear
# dependence at 1e-16 to 1e-14; below this ratio a direction is rounding, not data.
RANK_TOLERANCE = 1e-12


class NotIdentifiable(OedError):
    """The data, with the prior if there is one, do not determine every parameter.

    Attributes:
        singular_values: Of the factor with unit columns, largest first.
        direction: (p,) unit vector of scaled parameters that the data see least.
    """

    def __init__(self, message: str, singular_values: ndarray, direction: ndarray) -> None:
        super().__init__(message)
        self.singular_values = singular_values
        self.direction = direction


@dataclass(frozen=True)
class Solution:
    """A weighted least-squares solution, (7) and (8) of the paper.

    Attributes:
        parameters: (p,) xi-hat.
        information_factor: (p, p) upper triangular R of the data: Lambda = R^T R.
        posterior_factor: (p, p) the same with the prior's rows: P^-1 = R^T R.
        squares: (n,) weighted residual sum of squares of each joint.
        rows: Number of torque equations.
    """

    parameters: Float[ndarray, " p"]
    information_factor: Float[ndarray, "p p"]
    posterior_factor: Float[ndarray, "p p"]
    squares: Float[ndarray, " joints"]
    rows: int

    @property
    def covariance(self) -> Float[ndarray, "p p"]:
        """P of (8): right if the noise is white and has covariance R_v."""
        root = invert(self.posterior_factor)
        return root @ root.T


def triangularise(
    augmented: Float[ndarray, "rows width"],
) -> Float[ndarray, "width width"]:
    """Upper triangular T with T^T T = M^T M and a diagonal >= 0, for M = [A b]."""
    rows, width = augmented.shape
    if rows < width:
        augmented = np.vstack([augmented, np.zeros((width - rows, width))])
    geqrf, geqrf_lwork = get_lapack_funcs(("geqrf", "geqrf_lwork"), (augmented,))
    work, _ = geqrf_lwork(len(augmented), width)
    packed, *_ = geqrf(np.asfortranarray(augmented), lwork=int(work))
    triangle = np.triu(packed[:width])
    return triangle * np.where(np.diag(triangle) < 0, -1.0, 1.0)[:, None]


def factor_of(pieces: Iterable[Float[ndarray, "_ width"]]) -> Float[ndarray, "width width"]:
    """T of all rows of several pieces, at least one, that are never held together."""
    triangle = None
    for piece in pieces:
        rows = piece if triangle is None else np.concatenate([triangle, piece])
        triangle = triangularise(rows)
    if triangle is None:
        raise ValueError("no rows")
    return triangle


def augment(
    regressor: Float[ndarray, "rows p"], torque: Float[ndarray, " rows"]
) -> Float[ndarray, "rows width"]:
    """[A b] in the column-major order that LAPACK wants.

    Raises:
        ValueError: If an entry is not finite.
    """
    augmented = np.empty((len(torque), regressor.shape[1] + 1), order="F")
    augmented[:, :-1] = regressor
    augmented[:, -1] = torque
    if not np.isfinite(augmented).all():
        raise ValueError("the regressor or the torque has entries that are not finite")
    return augmented


def add_prior(
    triangle: Float[ndarray, "width width"], prior: Prior
) -> Float[ndarray, "width width"]:
    """T of the data rows together with the rows of the prior."""
    if not len(prior.factor):
        return triangle
    return triangularise(np.vstack([triangle, np.column_stack([prior.factor, prior.offset])]))


def solve(triangle: Float[ndarray, "width width"]) -> Float[ndarray, " p"]:
    """The parameters R^-1 z.

    Raises:
        NotIdentifiable: If R with unit columns is singular to `RANK_TOLERANCE`.
    """
    scaled, norms = unit_columns(triangle[:-1, :-1])
    _, singular, directions = np.linalg.svd(scaled)
    if not singular[-1] > RANK_TOLERANCE * singular[0]:
        raise NotIdentifiable(
            f"{len(norms)} parameters, but the least singular value of the regressor with unit "
            f"columns is {singular[-1]:.1e}, the largest {singular[0]:.1e}",
            singular,
            directions[-1],
        )
    return solve_triangular(scaled, triangle[:-1, -1]) / norms


def invert(factor: Float[ndarray, "p p"]) -> Float[ndarray, "p p"]:
    """R^-1 of an upper triangular factor."""
    # Unit columns: parameters of different units must not look like a bad condition.
    scaled, norms = unit_columns(factor)
    return solve_triangular(scaled, np.eye(len(norms))) / norms[:, None]


def unit_columns(
    matrix: Float[ndarray, "rows p"],
) -> tuple[Float[ndarray, "rows p"], Float[ndarray, " p"]]:
    """The matrix with columns of norm one, and the norms (one where a column is zero)."""
    norms = np.linalg.norm(matrix, axis=0)
    norms = np.where(norms > 0, norms, 1.0)
    return matrix / norms, norms
