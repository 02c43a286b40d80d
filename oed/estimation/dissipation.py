"""Whether friction takes energy out of the arm, as it must: the sign of the torques."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.errors import OedError

# Of the mean of |tau dq|: behind a joint torque sensor there may be no friction at all, and what is
# estimated of it has either sign.
LEAST_SHARE = 0.01


# The same of a single joint of which it is worth a word: what the model lacks may bend its friction.
CLEAR_SHARE = 0.05


def check_dissipation(
    friction: Mapping[str, float],
    dq: Float[ndarray, "samples joints"],
    torque: Float[ndarray, "samples joints"],
    name: str,
) -> None:
    """Refuse torques under which friction drives every joint.

    Args:
        friction: Estimates by name, of which Fc_1 ... and Fv_1 ... count.
        dq: (N, n) velocity [rad/s or m/s].
        torque: (N, n) [N m or N].
        name: Of the data set, for the message.

    Raises:
        OedError: If the friction of every joint is clearly negative.
    """
    if np.all(_share_taken(friction, dq, torque) < -LEAST_SHARE):
        raise OedError(
            f"{name}: with these torques friction drives every joint instead of braking it: signs of the "
            "tau columns, or of q, are reversed; oed check tells which where a test shows it"
        )


def driven_joints(
    friction: Mapping[str, float],
    dq: Float[ndarray, "samples joints"],
    torque: Float[ndarray, "samples joints"],
) -> list[int]:
    """Joints that friction clearly drives instead of braking them; arguments as above."""
    return np.flatnonzero(_share_taken(friction, dq, torque) < -CLEAR_SHARE).tolist()


def _share_taken(
    friction: Mapping[str, float],
    dq: Float[ndarray, "samples joints"],
    torque: Float[ndarray, "samples joints"],
) -> Float[ndarray, " joints"]:
    """Mean power that friction takes from each joint, as a share of the mean of |tau dq|."""
    joints = range(1, dq.shape[1] + 1)
    coulomb, viscous = (
        np.array([friction.get(f"{kind}_{j}", 0.0) for j in joints]) for kind in ("Fc", "Fv")
    )
    taken = coulomb * np.mean(np.abs(dq), axis=0) + viscous * np.mean(dq**2, axis=0)
    power = np.mean(np.abs(torque * dq), axis=0)
    return taken / np.where(power > 0, power, np.inf)
