"""A base that is mounted otherwise than declared: gravity points elsewhere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.effect import Parameter, State
from oed.dynamics.effects.on_reference import FollowsTorque
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.newton_euler import inverse_dynamics
from oed.dynamics.scalars import Scalar
from oed.robot.inertia import PARAMETER_SYMBOLS

STANDARD_GRAVITY = 9.80665  # [m/s^2], ISO 80000-3
LEVEL = 1e-9  # [m/s^2] declared gravity below which the arm is declared weightless


@dataclass(frozen=True)
class GravityDirection(FollowsTorque):
    """Torque of a small change of the gravity vector, for the parameters known so far.

    Gravity torque is linear in the gravity vector (it is an acceleration of the base: Luh,
    Walker and Paul 1980), so a unit column along each direction holds any change exactly as
    long as the parameters hold; a large tilt is reached by re-linearising.

    Attributes:
        reference: Gives the parameters.
        directions: Unit vectors in the base frame along which gravity may change.
        magnitude: Of gravity [m/s^2]: parameters are in units of it, that is in rad.
        unseen: Standard parameters that the declared gravity does not move, and a tilt does,
            such as the first moment of a link that turns about the vertical.
    """

    reference: ReferenceTorque
    directions: tuple[tuple[float, float, float], ...]
    magnitude: float = STANDARD_GRAVITY
    unseen: tuple[int, ...] = ()
    name = "gravity_direction"
    part = "body"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The change along each direction, over the magnitude; then its products with `unseen`."""
        tilts = [f"tilt_{k + 1}" for k in range(len(self.directions))]
        products = [
            Parameter(f"{tilt} {PARAMETER_SYMBOLS[k % 10]}_{k // 10 + 1}", "rad kg m", None)
            for tilt in tilts
            for k in self.unseen
        ]
        return (*(Parameter(tilt, "rad", None) for tilt in tilts), *products)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """All positions."""
        return tuple(f"q_{i + 1}" for i in range(self.reference.robot.n))

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """Torque of every joint at rest under each unit change."""
        robot = self.reference.robot
        units = [robot.with_parameters(np.eye(1, 10 * robot.n, k)[0]) for k in self.unseen]
        changes = [self.magnitude * np.array(direction) for direction in self.directions]
        known = [self.reference.gravity(state, change) for change in changes]
        rest = [0.0] * robot.n
        products = [
            inverse_dynamics(unit.with_gravity(change), state.q, rest, rest)
            for change in changes
            for unit in units
        ]
        return [dict(enumerate(torque)) for torque in (*known, *products)]


def tilt_directions(
    gravity: Float[ndarray, "3"],
) -> tuple[tuple[tuple[float, float, float], ...], float]:
    """Directions in which a declared gravity can turn, and its magnitude [m/s^2].

    Two at right angles to it, the first along the base axis that comes first of those that make at
    least 45 degrees with it: a gravity that is turned a little has nearly the same. All three axes
    for an arm declared weightless.
    """
    magnitude = float(np.linalg.norm(gravity))
    if magnitude < LEVEL:
        axes = np.eye(3)
        magnitude = STANDARD_GRAVITY
    else:
        down = gravity / magnitude
        nearest = np.eye(3)[np.flatnonzero(np.abs(down) <= np.sqrt(0.5))[0]]
        first = nearest - (nearest @ down) * down
        first /= np.linalg.norm(first)
        axes = np.stack([first, np.cross(down, first)])
    return tuple((float(x), float(y), float(z)) for x, y, z in axes), magnitude


def tilted(
    gravity: Float[ndarray, "3"], tilt: Float[ndarray, " directions"]
) -> Float[ndarray, "3"]:
    """Gravity after a tilt along `tilt_directions` [rad], of the same magnitude."""
    directions, magnitude = tilt_directions(gravity)
    change = np.array(directions).T @ tilt
    if len(directions) == 3:
        return magnitude * change
    angle = float(np.linalg.norm(change))
    if angle == 0.0:
        return gravity.copy()
    return np.cos(angle) * gravity + np.sin(angle) * magnitude * change / angle


def tilt_between(
    declared: Float[ndarray, "3"], actual: Float[ndarray, "3"]
) -> Float[ndarray, " directions"]:
    """The tilt along `tilt_directions` that turns one gravity into the other [rad].

    The inverse of `tilted`, but for the magnitude of an actual gravity.
    """
    directions, magnitude = tilt_directions(declared)
    axes = np.array(directions)
    if len(axes) == 3:
        return axes @ actual / magnitude
    sideways = axes @ actual
    angle = np.arctan2(np.linalg.norm(sideways), declared @ actual / magnitude)
    return angle * sideways / max(float(np.linalg.norm(sideways)), 1e-300)
