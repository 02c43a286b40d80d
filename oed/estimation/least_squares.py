"""Batch weighted least squares with a prior, (7) and (8) of the paper."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.noise import TorqueNoise, whiten, whitened
from oed.estimation.prior import Prior
from oed.estimation.row_pieces import RowPieces
from oed.estimation.triangular import Solution, add_prior, augment, factor_of, solve


def batch_least_squares(
    regressor: Float[ndarray, "rows p"] | RowPieces,
    torque: Float[ndarray, " rows"],
    joints: int,
    *,
    noise: TorqueNoise = None,
    prior: Prior | None = None,
) -> Solution:
    """Estimate all parameters at once, Calafiore 2001 (7)-(8).

    Args:
        regressor: H, row k n + j is joint j at sample k [N m per unit of the parameter]; an
            array, or in pieces.
        torque: y [N m].
        joints: n.
        noise: R_v, see `whiten`.
        prior: Mean and covariance of the parameters; None is R_xi = inf.

    Raises:
        ValueError: If shapes disagree or an entry is not finite.
        NotIdentifiable: If data and prior together leave a direction undetermined.
    """
    pieces = stacked(regressor, torque, joints)
    white_torque = whiten(torque, noise, joints)
    white = whitened(pieces, noise)
    data = factor_of(augment(rows, white_torque[place]) for place, rows in white.placed())
    posterior = add_prior(data, prior or Prior.flat(pieces.columns))
    parameters = solve(posterior)
    residual = white_torque - white.predict(parameters).reshape(-1)
    return Solution(
        parameters=parameters,
        information_factor=data[:-1, :-1],
        posterior_factor=posterior[:-1, :-1],
        squares=np.sum(residual.reshape(-1, joints) ** 2, axis=0),
        rows=len(torque),
    )


def stacked(
    regressor: Float[ndarray, "equations p"] | RowPieces,
    torque: Float[ndarray, " torques"],
    joints: int,
) -> RowPieces:
    """The regressor in pieces, if it and the torques belong together.

    Raises:
        ValueError: With both sizes that disagree.
    """
    if isinstance(regressor, RowPieces):
        if (regressor.rows, regressor.joints) != (len(torque), joints):
            raise ValueError(
                f"{regressor.rows} regressor rows of {regressor.joints} joints, but {len(torque)} "
                f"torques of {joints}"
            )
        return regressor
    check_stack(regressor, torque, joints)
    return RowPieces.of(regressor, joints)


def check_stack(
    regressor: Float[ndarray, "equations p"], torque: Float[ndarray, " torques"], joints: int
) -> None:
    """Refuse a regressor and torques that do not belong together.

    Raises:
        ValueError: With both sizes that disagree.
    """
    if len(regressor) != len(torque):
        raise ValueError(f"{len(regressor)} regressor rows, but {len(torque)} torques")
    if joints < 1 or len(torque) % joints:
        raise ValueError(f"{len(torque)} rows are not a multiple of {joints} joints")
