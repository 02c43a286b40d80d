"""Friction before sliding: a reversal first bends the contacts, then breaks them away."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.special import gammainc, gammaincinv

from oed.dynamics.effects.effect import Columns, Effect, Parameter, State
from oed.dynamics.scalars import Scalar, total, within

ELEMENTS = 12  # Dahl's curve within 1 %
SINGLE = 0.02  # below this roundness the elements differ by less than their number resolves


@dataclass(frozen=True)
class PreslidingHysteresis(Effect):
    """F_h (z - s): Coulomb friction built up over a distance instead of at once.

    z, from -1 to 1, is the mean of Maxwell elements (springs with a slider, Prandtl-Ishlinskii
    stops): each follows the motion until it slides at its own break-away distance (Al-Bender,
    Lampaert and Swevers 2005, without the drift). The distances follow a gamma distribution.
    Roundness 0 is one element, with straight flanks; 1/sqrt(2) gives after a reversal exactly
    Dahl's (1968) curve 1 - 2 exp(-x/distance), which LuGre (Canudas de Wit et al. 1995)
    shares at constant friction; 1 rounds more. Subtracting s leaves Coulomb friction to its
    own term: F_h is the share of it that is built up slowly. Elements start relaxed.

    Attributes:
        joint: Index of the joint.
        distance: Mean break-away distance [rad].
        roundness: Standard deviation of the distances over their mean.
        width: Velocity over which s turns [rad/s]; 0 for the exact sign.
    """

    joint: int
    distance: float
    roundness: float = 0.7
    width: float = 0.0
    name = "presliding_hysteresis"
    dissipates = True

    def __post_init__(self) -> None:
        if self.distance <= 0 or not 0 <= self.roundness <= 1:
            raise ValueError(f"{self.distance=} must be positive, {self.roundness=} in 0 to 1")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """F_h."""
        return (Parameter(f"Fh_{self.joint + 1}", "N m", self.joint),)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's position, by its reversals, and velocity."""
        return (f"q_{self.joint + 1}", f"dq_{self.joint + 1}")

    @property
    def distances(self) -> Float[ndarray, " elements"]:
        """Break-away distance of each element [rad], all of the same share."""
        if self.roundness < SINGLE:
            return np.array([self.distance])
        shape = self.roundness**-2
        edges = gammaincinv(shape, np.arange(ELEMENTS + 1) / ELEMENTS)
        # Mean of the gamma distribution between two quantiles.
        means = np.diff(gammainc(shape + 1, edges)) * ELEMENTS
        return self.distance * means

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """The deflection z less s.

        Raises:
            ValueError: If the state is symbolic.
        """
        q = state.motion(self.name).q[:, self.joint]
        z = maxwell_elements(q, self.distances).mean(axis=1)
        return [{self.joint: z - state.sign(state.dq[self.joint], self.width)}]

    @property
    def keeps(self) -> tuple[str, ...]:
        """Where the joint was, and the deflection of each element."""
        return remembered_elements(self.joint, len(self.distances))

    def begin(self, state: State) -> Sequence[Scalar]:
        """All elements relaxed."""
        return (state.q[self.joint], *[0.0] * len(self.distances))

    def recall(
        self,
        state: State,
        memory: Sequence[Scalar],
        step: float,  # noqa: ARG002  # the way counts, not the time
    ) -> tuple[Columns, Sequence[Scalar]]:
        """The deflection z less s."""
        q, dq = state.q[self.joint], state.dq[self.joint]
        z = moved_elements(q - memory[0], memory[1:], self.distances)
        mean = total(z) * (1 / len(z))
        return [{self.joint: mean - state.sign(dq, self.width)}], (q, *z)


def remembered_elements(joint: int, count: int) -> tuple[str, ...]:
    """Names of what Maxwell elements of a joint keep."""
    return (f"last q_{joint + 1}", *(f"z{k + 1} of q_{joint + 1}" for k in range(count)))


def moved_elements(
    way: Scalar, z: Sequence[Scalar], distances: Float[ndarray, " elements"]
) -> list[Scalar]:
    """Deflections after a way [rad], each element sliding at its own distance."""
    pairs = zip(z, distances.tolist(), strict=True)
    return [within(own + way * (1 / distance), -1.0, 1.0) for own, distance in pairs]


def maxwell_elements(
    q: Float[ndarray, " samples"], distances: Float[ndarray, " elements"]
) -> Float[ndarray, "samples elements"]:
    """Deflection of Maxwell elements, from -1 to 1, relaxed at the first sample.

    Args:
        q: Position [rad or m].
        distances: Break-away distance of each [rad or m].
    """
    # An element that moves one way slides or does not: only reversals have to be walked through.
    steps = np.diff(q)
    moving = np.flatnonzero(steps)
    turns = moving[1:][np.diff(np.sign(steps[moving])) != 0]
    starts = np.concatenate([[0], turns])
    z = np.zeros((len(starts), len(distances)))
    for k, way in enumerate(np.diff(q[starts])[:, None] / distances):
        z[k + 1] = np.minimum(np.maximum(z[k] + way, -1.0), 1.0)
    run = np.repeat(np.arange(len(starts)), np.diff(starts, append=len(q)))
    return np.clip(z[run] + (q - q[starts[run]])[:, None] / distances, -1.0, 1.0)
