"""A posture with room about it."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.collision import FAR, Surroundings
from oed.design.joint_sums import roomiest_posture
from oed.errors import NoUsableResult
from oed.robot import JointLimits

POSTURES = 400  # random ones among which it is sought: one that is clear in a hundred is missed by 2 % of seeds


class NoClearPosture(NoUsableResult):
    """No posture was found in which the arm is clear of itself and its box."""


def clear_posture(
    limits: JointLimits, surroundings: Surroundings, rng: np.random.Generator
) -> Float[ndarray, " joints"]:
    """Mid-range, or the random posture with most room about it if that has more.

    Args:
        limits: Finite in position.
        surroundings: What may be hit.
        rng: Of the postures.

    Raises:
        NoClearPosture: If none is clear.
    """
    lower, upper = limits.position.T
    drawn = rng.uniform(lower, upper, (POSTURES, len(lower)))
    sums = drawn @ limits.sum_factors.T
    is_within = ((limits.sum_bounds[:, 0] < sums) & (sums < limits.sum_bounds[:, 1])).all(axis=1)
    postures = [roomiest_posture(limits), *drawn[is_within]]
    spare = [_room(q, surroundings) for q in postures]
    best = int(np.argmax(spare))
    if spare[best] < 0.0:
        raise NoClearPosture(
            f"none of {len(postures)} postures keeps the arm clear of itself and its box by "
            f"{1e3 * surroundings.clearance:g} mm: check the box and the file, or ask for less "
            f"(--clearance){surroundings.mostly_short}"
        )
    return postures[best]


def _room(q: Float[ndarray, " joints"], surroundings: Surroundings) -> float:
    """Least spare distance [m]; of links that are close by design only where they fall short.

    Those say nothing else: in a compact wrist they are as near in any posture.
    """
    least = FAR - surroundings.clearance
    for pair, distance in surroundings.distances(q).items():
        spare = distance - surroundings.wanted(pair)
        if spare < 0.0 or surroundings.wanted(pair) == surroundings.clearance:
            least = min(least, spare)
    return least
