"""Whether an arm with its loads explains what was measured."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.errors import NoUsableResult

# Residual over torque. No model at all leaves 1; a joint whose torque is mostly noise may leave a
# little more, as the others' torques decide of what they share.
MOST_LEFT = 2.0


def check_explained(shares: Float[ndarray, " joints"], names: Sequence[str]) -> None:
    """Refuse a fit that leaves more than there was to explain.

    Args:
        shares: Residual over torque, or over current, of each joint.
        names: Of the joints.

    Raises:
        NoUsableResult: Naming the joint that is left worst.
    """
    worst = int(np.argmax(shares))
    if not shares[worst] <= MOST_LEFT:
        raise NoUsableResult(
            f"arm and load leave {shares[worst]:.3g} times the torque of {names[worst]}, more than no "
            "model at all would: the data sets, or the model, do not fit together; compare their "
            "[units], sign and current_to_torque"
        )
