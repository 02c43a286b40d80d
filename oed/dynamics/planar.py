"""The paper's closed-form regressor of the planar two-link arm (16)."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion


def planar_regressor(motion: Motion, l_1: float) -> Float[ndarray, "samples 2 8"]:
    """Regressor (16), with sgn(0) = 0.

    Its columns are those of Izz_1 + m_2 l_1^2, mx_2, my_2, Izz_2, Fc_1, Fv_1, Fc_2, Fv_2.

    Args:
        motion: Of two joints.
        l_1: Length of the first link [m].
    """
    c, s = np.cos(motion.q[:, 1]), np.sin(motion.q[:, 1])
    dq_1, dq_2 = motion.dq.T
    ddq_1, ddq_2 = motion.ddq.T
    zero = np.zeros(len(motion))
    both = 2 * ddq_1 + ddq_2
    coriolis = dq_2 * (2 * dq_1 + dq_2)
    row_1 = [
        ddq_1,
        l_1 * (c * both - s * coriolis),
        l_1 * (-s * both - c * coriolis),
        ddq_1 + ddq_2,
        np.sign(dq_1),
        dq_1,
        zero,
        zero,
    ]
    row_2 = [
        zero,
        l_1 * (c * ddq_1 + s * dq_1**2),
        l_1 * (-s * ddq_1 + c * dq_1**2),
        ddq_1 + ddq_2,
        zero,
        zero,
        np.sign(dq_2),
        dq_2,
    ]
    return np.stack([np.stack(row_1, axis=1), np.stack(row_2, axis=1)], axis=1)
