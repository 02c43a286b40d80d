"""Position limits narrowed until hardly a posture within them collides.

An arm whose joints turn further than its links allow has most of its range blocked. A design
that keeps clear by small changes needs a range to begin with in which collisions are rare.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.design.clear_posture import clear_posture
from oed.design.collision import Surroundings
from oed.errors import NoUsableResult
from oed.robot import JointLimits

RARE = 0.02  # share of random postures that may collide
DRAWN = 600  # postures looked at a time
FEWEST = 200  # within the range, below which new ones are drawn
DRAWS = 40
# Of one joint's range, each time. Collisions often fill the middle of a side (an elbow that may
# turn twice): a small step alone would see nothing to gain.
NARROWINGS = (0.92, 0.8, 0.65, 0.5, 0.35)


class NoClearRange(NoUsableResult):
    """No range of positions was found in which the arm is clear of itself and its box."""


@dataclass(frozen=True)
class ClearLimits:
    """Limits within which collisions are rare.

    Attributes:
        limits: With narrower positions.
        centre: (n,) a posture that is clear, about which the range was narrowed.
        factors: (n,) share of each joint's range that is left.
    """

    limits: JointLimits
    centre: Float[ndarray, " joints"]
    factors: Float[ndarray, " joints"]


def clear_limits(
    limits: JointLimits, surroundings: Surroundings, rng: np.random.Generator
) -> ClearLimits:
    """Narrow the joint that helps most, again and again, until collisions are rare.

    Args:
        limits: Finite in position.
        surroundings: What may be hit.
        rng: Of the postures.

    Raises:
        NoClearPosture: If no posture is clear.
        NoClearRange: If there is no range about one.
    """
    position = limits.position
    centre = clear_posture(limits, surroundings, rng)
    reach = np.abs(position - centre[:, None])
    factors = np.ones(len(position))
    for _ in range(DRAWS):
        share = rng.uniform(-1.0, 1.0, (DRAWN, len(position))) * factors
        q = centre + np.where(share < 0, share * reach[:, 0], share * reach[:, 1])
        is_bad = np.array([not surroundings.is_clear(posture) for posture in q])
        extent = np.abs(share)
        inside = np.ones(DRAWN, dtype=bool)
        while inside.sum() >= FEWEST:
            if is_bad[inside].mean() <= RARE:
                narrow = np.stack([-factors * reach[:, 0], factors * reach[:, 1]], axis=1)
                return ClearLimits(limits.with_(position=centre[:, None] + narrow), centre, factors)
            steps = [
                (
                    _gain(is_bad, inside, extent[:, j] <= narrower * factors[j], narrower),
                    j,
                    narrower,
                )
                for j in range(len(position))
                for narrower in NARROWINGS
            ]
            gain, best, narrower = max(steps)
            if gain <= 0.0:
                break
            factors[best] *= narrower
            inside &= extent[:, best] <= factors[best]
    raise NoClearRange(
        "no range of positions was found in which the arm is clear of collisions"
        f"{surroundings.mostly_short}"
    )


def _gain(
    is_bad: Bool[ndarray, " postures"],
    inside: Bool[ndarray, " postures"],
    kept: Bool[ndarray, " postures"],
    factor: float,
) -> float:
    """How much smaller the share of collisions gets, per halving of the range."""
    left = inside & kept
    if left.sum() < FEWEST / 4:
        return -np.inf
    return float((is_bad[inside].mean() - is_bad[left].mean()) / -np.log2(factor))
