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

RARE = (
    0.02  # share of random postures that may collide: a repair leads the motion round them; assumed
)
# Postures looked at a time, and the fewest of them within the range, below which new ones are drawn:
# so few still tell a share of 0.02 within 0.01, one standard deviation.
DRAWN, FEWEST = 600, 200
DRAWS = 40  # arms of up to ten joints took up to 20
HALVINGS = 8  # of all joints together after that: to a degree of a whole turn
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

    Where that does not end, all joints are narrowed alike: about a clear posture with room there
    is such a range.

    Args:
        limits: Finite in position.
        surroundings: What may be hit.
        rng: Of the postures.

    Raises:
        NoClearPosture: If no posture is clear.
        NoClearRange: If there is no range about one.
    """
    centre = clear_posture(limits, surroundings, rng)
    reach = np.abs(limits.position - centre[:, None])
    # A joint that turns more than once comes by the same postures again.
    reach = np.where(surroundings.turns[:, None], np.minimum(reach, np.pi), reach)
    factors = np.ones(len(centre))
    for draw in range(DRAWS + HALVINGS):
        share = rng.uniform(-1.0, 1.0, (DRAWN, len(centre))) * factors
        q = centre + np.where(share < 0, share * reach[:, 0], share * reach[:, 1])
        is_bad = np.array([not surroundings.is_clear(posture) for posture in q])
        factors, is_rare = _narrowed(factors, np.abs(share), is_bad)
        if is_rare:
            narrow = factors[:, None] * reach * (-1.0, 1.0)
            left = np.diff(narrow, axis=1)[:, 0] / np.diff(limits.position, axis=1)[:, 0]
            return ClearLimits(limits.with_(position=centre[:, None] + narrow), centre, left)
        factors = factors / 2 if draw >= DRAWS else factors
    raise NoClearRange(
        "no range of positions was found in which the arm is clear of collisions"
        f"{surroundings.mostly_short}"
    )


def _narrowed(
    factors: Float[ndarray, " joints"],
    extent: Float[ndarray, "postures joints"],
    is_bad: Bool[ndarray, " postures"],
) -> tuple[Float[ndarray, " joints"], bool]:
    """Factors narrowed as far as some postures tell, and whether collisions are rare within them."""
    factors, inside = factors.copy(), np.ones(len(is_bad), dtype=bool)
    while inside.sum() >= FEWEST:
        if is_bad[inside].mean() <= RARE:
            return factors, True
        steps = [
            (_gain(is_bad, inside, extent[:, j] <= narrower * factors[j], narrower), j, narrower)
            for j in range(len(factors))
            for narrower in NARROWINGS
        ]
        gain, best, narrower = max(steps)
        if gain <= 0.0:
            break
        factors[best] *= narrower
        inside &= extent[:, best] <= factors[best]
    return factors, False


def _gain(
    is_bad: Bool[ndarray, " postures"],
    inside: Bool[ndarray, " postures"],
    kept: Bool[ndarray, " postures"],
    factor: float,
) -> float:
    """How much smaller the share of collisions gets, per halving of the range, at the least.

    By chance alone it gets smaller too, and a joint that has no part in it would be narrowed: a
    standard deviation of the share among the postures that fall out is taken off.
    """
    left, out = inside & kept, inside & ~kept
    if left.sum() < FEWEST / 4 or not out.any():
        return -np.inf
    share, of_all = is_bad[left].mean(), is_bad[inside].mean()
    chance = np.sqrt(of_all * (1 - of_all) / out.sum()) * out.sum() / inside.sum()
    return float((of_all - share - chance) / -np.log2(factor))
