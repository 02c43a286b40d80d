"""Batch weighted least squares with a prior, (7) and (8) of the paper."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.noise import TorqueNoise, whiten
from oed.estimation.prior import Prior
from oed.estimation.triangular import Solution, add_prior, augment, solve, triangularise


def batch_least_squares(
    regressor: Float[ndarray, "rows p"],
    torque: Float[ndarray, " rows"],
    joints: int,
    *,
    noise: TorqueNoise = None,
    prior: Prior | None = None,
) -> Solution:
    """Estimate all parameters at once, Calafiore 2001 (7)-(8).

    Args:
        regressor: H, row k n + j is joint j at sample k [N m per unit of the parameter].
        torque: y [N m].
        joints: n.
        noise: R_v, see `whiten`.
        prior: Mean and covariance of the parameters; None is R_xi = inf.

    Raises:
        ValueError: If shapes disagree or an entry is not finite.
        NotIdentifiable: If data and prior together leave a direction undetermined.
    """
    check_stack(regressor, torque, joints)
    white_regressor = whiten(regressor, noise, joints)
    white_torque = whiten(torque, noise, joints)
    data = triangularise(augment(white_regressor, white_torque))
    posterior = add_prior(data, prior or Prior.flat(regressor.shape[1]))
    parameters = solve(posterior)
    residual = white_torque - white_regressor @ parameters
    return Solution(
        parameters=parameters,
        information_factor=data[:-1, :-1],
        posterior_factor=posterior[:-1, :-1],
        squares=np.sum(residual.reshape(-1, joints) ** 2, axis=0),
        rows=len(torque),
    )


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
