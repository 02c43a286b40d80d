"""What hiding an effect in an arm gives back: the changed arm, and the truth for the judge."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from studies.bench.arm import Arm

FIRST_SAMPLE = 1.5  # [s] on the arm's clock: the first recording's lead-in is not logged


@dataclass(frozen=True)
class Injected:
    """An arm with one more thing hidden in it.

    Attributes:
        arm: The changed arm.
        parameters: Injected values whose meaning does not hang on the formula, as
            (value, SI unit).
        in_catalogue: Injected values in the catalogue's own terms and SI units, by a pattern of
            the name that it gives the parameter, such as "Fs_*".
        coordinates: Where nothing in the catalogue fits: the coordinates that the torque depends
            on, such as ("q_1", "dq_2"); several if either set says the same.
    """

    arm: Arm
    parameters: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    in_catalogue: Mapping[str, float] = field(default_factory=dict)
    coordinates: tuple[tuple[str, ...], ...] = ()


# (arm, joint, size: 1 is realistic, draws of the details) -> arm with the effect
Inject = Callable[[Arm, int, float, np.random.Generator], Injected]


def either_sign(rng: np.random.Generator) -> float:
    """+1 or -1."""
    return float(rng.choice([-1.0, 1.0]))


def another_joint(arm: Arm, joint: int, rng: np.random.Generator) -> int:
    """A neighbour of a joint, where it moves enough to matter."""
    n = arm.robot.n
    return int(rng.choice([i for i in (joint - 1, joint + 1) if 0 <= i < n]))


def middle(arm: Arm, joint: int) -> float:
    """Of a joint's range [rad]."""
    return float(arm.robot.limits.position[joint].mean())


def named(*coordinates: str) -> tuple[str, ...]:
    """Coordinates with joints counted from 0, as reports count them: from 1."""
    return tuple(sorted(_counted_from_one(coordinate) for coordinate in coordinates))


def _counted_from_one(coordinate: str) -> str:
    symbol, _, joint = coordinate.partition("_")
    return f"{symbol}_{int(joint) + 1}" if joint else symbol


def wave_in_catalogue(
    symbol: str, amplitude: float, periods: float, phase: float
) -> dict[str, float]:
    """A cosine of the angle as the catalogue's two columns and their harmonic."""
    return {
        f"{symbol}*_cos_*": float(amplitude * np.cos(phase)),
        f"{symbol}*_sin_*": float(-amplitude * np.sin(phase)),
        "harmonic": periods,
    }
