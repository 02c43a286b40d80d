"""Recursive least squares: the paper's recursive form by orthogonal updates."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.linalg import get_lapack_funcs

from oed.estimation.least_squares import check_stack
from oed.estimation.noise import TorqueNoise, whiten
from oed.estimation.prior import Prior
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
    regressor: Float[ndarray, "rows p"],
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
        regressor: H, sample-major.
        torque: y [N m].
        joints: n.
        noise: R_v, see `whiten`.
        prior: Where the recursion starts; None is P_0 = inf.
        block: Rows that one step takes in.

    Raises:
        ValueError: If shapes disagree, an entry is not finite, or block < 1.
        NotIdentifiable: If data and prior together leave a direction undetermined.
    """
    check_stack(regressor, torque, joints)
    if block < 1:
        raise ValueError(f"{block=} must be at least one row")
    white = augment(whiten(regressor, noise, joints), whiten(torque, noise, joints))
    rows, width = white.shape
    prior = prior or Prior.flat(width - 1)
    data = np.zeros((width, width))
    posterior = add_prior(data, prior)
    ends = np.append(np.arange(block, rows, block), rows)
    parameters = np.full((len(ends), width - 1), np.nan)
    std = np.full_like(parameters, np.nan)
    start = 0
    for step, end in enumerate(ends):
        data = _rotate_in(data, white[start:end])
        posterior = _rotate_in(posterior, white[start:end])
        start = end
        if _is_determined(posterior[:-1, :-1]):
            parameters[step] = solve(posterior)
            std[step] = np.linalg.norm(invert(posterior[:-1, :-1]), axis=1)
    final = solve(posterior)
    residual = (white[:, -1] - white[:, :-1] @ final).reshape(-1, joints)
    solution = Solution(
        parameters=final,
        information_factor=triangularise(data)[:-1, :-1],
        posterior_factor=triangularise(posterior)[:-1, :-1],
        squares=np.sum(residual**2, axis=0),
        rows=rows,
    )
    return RecursiveEstimate(solution, ends, parameters, std)


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
