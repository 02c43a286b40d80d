"""By how much friction differs from one day to another, as a prior.

Terms of a friction curve resemble one another, and their numbers mean little one by one. What is bounded is
torque: along the recordings, each independent way in which a joint's curve can change makes a share of its
friction torque (the g-prior of Zellner 1986).
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.load.torque_equations import TorqueEquations
from oed.estimation.triangular import triangularise, unit_columns

# From one day to the next, of friction's torque: each day's may be as unlike the other's as it is large.
# Warming alone changes viscous friction by a fifth (Bittencourt, Wernholt, Sander-Tavallaey and Brogardh
# 2010, figure 5); to bound it there narrows a mass by less than 1 in 100.
FRICTION_CHANGE = 1.0
LEAST_FRICTION = 1e-3  # of the largest torque: of drives whose friction is not known yet
UNSEEN = 1e-4  # of a curve's torque, below which a direction makes none that recordings show


def friction_change(
    equations: TorqueEquations, mean: Float[ndarray, " x"]
) -> Float[ndarray, "x x"]:
    """Covariance by which friction may differ on the day of some recordings.

    Args:
        equations: Of the recordings.
        mean: (x,) of the parameters on the other day.
    """
    changing = np.flatnonzero(equations.model.is_friction)
    columns = np.concatenate(equations.columns)
    largest = np.sqrt(np.mean((columns @ mean[: columns.shape[2]]) ** 2, axis=0)).max()
    least = LEAST_FRICTION * max(float(largest), 1.0)
    found = np.zeros((len(mean), len(mean)))
    for joint in range(columns.shape[1]):
        own = changing[np.any(columns[:, joint, changing] != 0, axis=0)]
        if not len(own):
            continue
        curve = columns[:, joint, own]
        torque = max(float(np.sqrt(np.mean((curve @ mean[own]) ** 2))), least)
        factor, norms = unit_columns(triangularise(curve / np.sqrt(len(curve))))
        _, sizes, right = np.linalg.svd(factor)
        half = right.T / np.maximum(sizes, UNSEEN * sizes[0]) / norms[:, None]
        found[np.ix_(own, own)] = (FRICTION_CHANGE * torque) ** 2 * half @ half.T
    return found
