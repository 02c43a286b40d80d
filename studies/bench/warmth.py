"""Temperatures of an arm's joints, as its thermometers show them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.scalars import Scalar, sin

MILD = 25.0  # [degrees Celsius] about which all of them are
SWING = (4.0, 10.0)  # [K]
SWINGS_IN = (50.0, 150.0)  # [s] as a hall's heating does
IDLE_SHARE = 0.5  # of the arms whose friction does not feel its temperature, that have thermometers


@dataclass(frozen=True)
class SwingingWarmth:
    """One joint whose temperature swings, the others at rest.

    Attributes:
        joint: Index.
        joints: How many there are.
        swing: [K].
        period: [s].
        phase: At the start of the arm's clock [rad].
    """

    joint: int
    joints: int
    swing: float
    period: float
    phase: float

    @classmethod
    def draw(cls, joint: int, joints: int, rng: np.random.Generator) -> SwingingWarmth:
        """Some swing of some period."""
        return cls(
            joint, joints, rng.uniform(*SWING), rng.uniform(*SWINGS_IN), rng.uniform(0, 2 * np.pi)
        )

    def warmer(self, t: Scalar) -> Scalar:
        """How much warmer than mild the joint is [K]."""
        return self.swing * sin(2 * np.pi * t / self.period + self.phase)

    def __call__(self, t: Float[ndarray, " samples"]) -> Float[ndarray, "samples joints"]:
        """Temperature of every joint [degrees Celsius]."""
        shown = np.full((len(t), self.joints), MILD)
        shown[:, self.joint] += self.warmer(t)
        return shown


def idle_warmth(joints: int, rng: np.random.Generator) -> SwingingWarmth | None:
    """Thermometers of an arm whose friction does not feel them; None where it has none."""
    if rng.random() > IDLE_SHARE:
        return None
    return SwingingWarmth.draw(int(rng.integers(joints)), joints, rng)
