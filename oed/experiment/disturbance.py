"""Random torque between what the controller asks for and what the joint gets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import lfilter

from oed.errors import OedError

TRACE = 0.01  # of the first guess


class CalibrationFailed(OedError):
    """The torque variance with hardly any disturbance already exceeds the target.

    Attributes:
        floor: (n,) variances with a trace of disturbance [N^2 m^2].
        target: (n,) variances asked for [N^2 m^2].
    """

    def __init__(self, message: str, floor: ndarray, target: ndarray) -> None:
        super().__init__(message)
        self.floor = floor
        self.target = target


@dataclass(frozen=True)
class Disturbance:
    """Stationary Gauss-Markov torque: standard deviation and corner frequency per joint.

    Attributes:
        std: (n,) [N m].
        corner: (n,) frequency where the spectrum has fallen to half [rad/s]; inf is white.
    """

    std: tuple[float, ...]
    corner: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.std) != len(self.corner):
            raise ValueError(f"{len(self.std)} levels, {len(self.corner)} corners")
        if min(self.std) < 0 or min(self.corner) <= 0:
            raise ValueError("levels must not be negative, corners must be positive")

    @classmethod
    def none(cls, joints: int) -> Disturbance:
        """No disturbance."""
        return cls((0.0,) * joints, (np.inf,) * joints)

    def with_std(self, std: Float[ndarray, " joints"]) -> Disturbance:
        """The same colour at another level."""
        return Disturbance(tuple(float(s) for s in std), self.corner)

    def sample(
        self, samples: int, runs: int, period: float, rng: np.random.Generator
    ) -> Float[ndarray, "samples joints runs"]:
        """Independent stationary realisations, one a run."""
        white = rng.standard_normal((samples, len(self.std), runs))
        result = np.empty_like(white)
        for j, (std, corner) in enumerate(zip(self.std, self.corner, strict=True)):
            memory = float(np.exp(-corner * period))
            scaled = white[:, j] * np.sqrt(1 - memory**2)
            scaled[0] = white[0, j]  # starts in the stationary distribution
            result[:, j] = std * np.asarray(lfilter([1.0], [1.0, -memory], scaled, axis=0))
        return result


def calibrate(
    start: Disturbance,
    target: Float[ndarray, " joints"],
    variances: Callable[[Disturbance], Float[ndarray, " joints"]],
    *,
    rounds: int = 3,
) -> Disturbance:
    """The level at which the experiment shows given torque variances.

    The loop is close to linear, so the variance is a floor, from quantisation, plus a
    multiple of the level squared; the multiple is refined round by round.

    Args:
        start: Colour, and a first guess of the level.
        target: (n,) torque variances over repetitions [N^2 m^2].
        variances: Runs the experiment and returns those variances; same seed every time.
        rounds: Refinements.

    Raises:
        CalibrationFailed: If quantisation alone exceeds a target.
    """
    # Without any disturbance every run would read the same steps: a trace shakes them.
    floor = variances(start.with_std(TRACE * np.array(start.std)))
    if np.any(floor >= target):
        joint = int(np.argmax(floor / target))
        raise CalibrationFailed(
            f"joint {joint + 1}: variance {floor[joint]:.4g} N^2 m^2 with hardly any disturbance, "
            f"{target[joint]:.4g} asked for",
            floor,
            target,
        )
    level = np.array(start.std)
    for _ in range(rounds):
        found = variances(start.with_std(level))
        level = level * np.sqrt((target - floor) / np.maximum(found - floor, 1e-3 * target))
    return start.with_std(level)
