"""Recursive least squares: the paper's recursive form by orthogonal updates."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.linalg import get_lapack_funcs

from oed.estimation.least_squares import stacked
from oed.estimation.noise import TorqueNoise, whiten, whitened
from oed.estimation.prior import Prior
from oed.estimation.row_pieces import RowPieces
from oed.estimation.triangular import (
    RANK_TOLERANCE,
    Solution,
    add_prior,
    augment,
    invert,
    solve,
    triangularise,
    unit_columns,
)


@dataclass(frozen=True)
class RecursiveEstimate:
    """The estimate after every block of rows, as in figure 4 of the paper.

    Attributes:
        solution: After the last row; equal to the batch solution.
        rows: (steps,) rows used so far.
        parameters: (steps, p) estimates; NaN while data and prior leave them undetermined.
        std: (steps, p) square roots of diag P; NaN as above.
    """

    solution: Solution
    rows: Int[ndarray, " steps"]
    parameters: Float[ndarray, "steps p"]
    std: Float[ndarray, "steps p"]


def recursive_least_squares(
    regressor: Float[ndarray, "rows p"] | RowPieces,
    torque: Float[ndarray, " rows"],
    joints: int,
    *,
    noise: TorqueNoise = None,
    prior: Prior | None = None,
    block: int = 1,
) -> RecursiveEstimate:
    """Estimate row by row (or block by block) and keep the history.

    The paper updates P by K H P, which loses symmetry and definiteness to rounding; the
    array form rotates each row into a square root of P^-1 instead (Bierman 1977, Factorization
    Methods for Discrete Sequential Estimation), with the same estimates in exact arithmetic,
    and it can start without a prior.

    Args:
        regressor: H, sample-major; an array, or in pieces.
        torque: y [N m].
        joints: n.
        noise: R_v, see `whiten`.
        prior: Where the recursion starts; None is P_0 = inf.
        block: Rows that one step takes in.

    Raises:
        ValueError: If shapes disagree, an entry is not finite, or block < 1.
        NotIdentifiable: If data and prior together leave a direction undetermined.
    """
    pieces = stacked(regressor, torque, joints)
    if block < 1:
        raise ValueError(f"{block=} must be at least one row")
    white, white_torque = whitened(pieces, noise), whiten(torque, noise, joints)
    rows, width = pieces.rows, pieces.columns + 1
    prior = prior or Prior.flat(width - 1)
    data = np.zeros((width, width))
    posterior = add_prior(data, prior)
    ends = np.append(np.arange(block, rows, block), rows)
    parameters = np.full((len(ends), width - 1), np.nan)
    std = np.full_like(parameters, np.nan)
    for end, block_rows in _blocks(white, white_torque, ends):
        data = _rotate_in(data, block_rows)
        posterior = _rotate_in(posterior, block_rows)
        step = int(np.searchsorted(ends, end))
        if end == ends[step] and _is_determined(posterior[:-1, :-1]):
            parameters[step] = solve(posterior)
            std[step] = np.linalg.norm(invert(posterior[:-1, :-1]), axis=1)
    final = solve(posterior)
    residual = white_torque.reshape(-1, joints) - white.predict(final)
    solution = Solution(
        parameters=final,
        information_factor=triangularise(data)[:-1, :-1],
        posterior_factor=triangularise(posterior)[:-1, :-1],
        squares=np.sum(residual**2, axis=0),
        rows=rows,
    )
    return RecursiveEstimate(solution, ends, parameters, std)


def _blocks(
    white: RowPieces, torque: Float[ndarray, " rows"], ends: Int[ndarray, " steps"]
) -> Iterator[tuple[int, Float[ndarray, "_ width"]]]:
    """Augmented rows up to each end, or that of a piece where it comes before, and where they end."""
    for place, piece in white.placed():
        rows = augment(piece, torque[place])
        inside = ends[(ends > place.start) & (ends < place.stop)].tolist()
        for first, last in pairwise([place.start, *inside, place.stop]):
            yield last, rows[first - place.start : last - place.start]


def _rotate_in(
    triangle: Float[ndarray, "width width"], rows: Float[ndarray, "rows width"]
) -> Float[ndarray, "width width"]:
    # LAPACK's tpqrt knows that the upper block is triangular: width^2 operations a row.
    (tpqrt,) = get_lapack_funcs(("tpqrt",), (triangle,))
    updated, *_ = tpqrt(0, min(32, len(triangle)), triangle, rows)
    return np.triu(updated)


def _is_determined(factor: Float[ndarray, "p p"]) -> bool:
    scaled, _ = unit_columns(factor)
    singular = np.linalg.svd(scaled, compute_uv=False)
    return bool(singular[-1] > RANK_TOLERANCE * singular[0])
