"""Cubic B-splines of a coordinate of the motion, for numbers and symbols."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.effects.effect import State
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.effects.thermal import since
from oed.dynamics.scalars import Scalar, magnitude, mul

DEGREE = 3
SMALLEST_SPAN = 1e-9  # a coordinate that moves less than this has no shape to find

CoordinateKind = Literal["q", "dq", "ddq", "|dq|", "tau", "|tau|", "time"]


@dataclass(frozen=True)
class Coordinate:
    """What a stand-in is a function of.

    Attributes:
        kind: Position, velocity, acceleration, their magnitudes' |dq|, the modelled torque,
            its magnitude, or time since the first sample.
        joint: Index of the joint; ignored for time.
        reference: Gives the torque, where that is the coordinate.
    """

    kind: CoordinateKind
    joint: int = 0
    reference: ReferenceTorque | None = None

    def __post_init__(self) -> None:
        if "tau" in self.kind and self.reference is None:
            raise ValueError(f"a coordinate of {self.kind=} needs a reference torque")

    @property
    def name(self) -> str:
        """Name as in `Effect.depends_on`."""
        if self.kind == "time":
            return self.kind
        return f"{self.kind.strip('|')}_{self.joint + 1}"

    def of(self, state: State) -> Scalar:
        """Its value."""
        if self.kind == "time":
            return since(state.t, None)
        if self.reference is not None and "tau" in self.kind:
            value = self.reference.total(state)[self.joint]
        else:
            value = getattr(state, self.kind.strip("|"))[self.joint]
        return magnitude(value) if self.kind.startswith("|") else value


@dataclass(frozen=True)
class Spline:
    """Cubic B-splines in one coordinate on knots where the data are; constant outside.

    Attributes:
        coordinate: What it is a function of.
        breaks: Increasing places where cubic pieces meet, from the least to the largest
            value that the data cover.
    """

    coordinate: Coordinate
    breaks: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.breaks) < 2 or not all(np.diff(self.breaks) > 0):
            raise ValueError(f"{self.breaks=} must increase and be two or more")

    @classmethod
    def covering(
        cls, coordinate: Coordinate, values: Float[ndarray, " samples"], pieces: int
    ) -> Spline:
        """Breaks at quantiles of the data, so that every piece is covered equally well.

        Raises:
            ValueError: If the values are all the same.
        """
        breaks = np.unique(np.quantile(values, np.linspace(0, 1, pieces + 1)))
        far_enough = np.concatenate([[True], np.diff(breaks) > SMALLEST_SPAN])
        if far_enough.sum() < 2:
            raise ValueError(f"{coordinate.name} does not vary: no function of it can be found")
        return cls(coordinate, tuple(float(x) for x in breaks[far_enough]))

    def __len__(self) -> int:
        return len(self.breaks) - 1 + DEGREE

    @property
    def knots(self) -> Float[ndarray, " knots"]:
        """Knot sequence, with the ends repeated."""
        return np.concatenate([[self.breaks[0]] * DEGREE, self.breaks, [self.breaks[-1]] * DEGREE])

    def basis(self, state: State) -> list[Scalar]:
        """Values of the basis functions; outside the coverage those of the nearest end.

        The recursion of de Boor, written for numbers and symbols alike.
        """
        knots, low, high = self.knots, self.breaks[0], self.breaks[-1]
        x = self.coordinate.of(state)
        below, above = 1.0 * (x < low), 1.0 * (x >= high)
        x = low * below + high * above + x * (1.0 - below - above)
        values: list[Scalar] = [
            (x >= knots[i]) * (x < knots[i + 1]) * (1.0 - above) if knots[i] < knots[i + 1] else 0.0
            for i in range(len(knots) - 1)
        ]
        values[len(self) - 1] += above  # the last piece is closed on the right
        for degree in range(1, DEGREE + 1):
            values = [
                _raised(x, knots[i : i + degree + 2], values[i], values[i + 1])
                for i in range(len(values) - 1)
            ]
        return values

    def covered(self, state: State) -> Bool[ndarray, " samples"]:
        """Where the coordinate is within the coverage."""
        x = np.asarray(self.coordinate.of(state))
        return (x >= self.breaks[0]) & (x <= self.breaks[-1])

    def roughness(self) -> Float[ndarray, "differences basis"]:
        """Second differences of coefficients over the basis functions' centres.

        A penalty of their squares (Eilers and Marx 1996) draws the function to a line.
        """
        knots = self.knots
        centres = np.array([knots[i + 1 : i + 1 + DEGREE].mean() for i in range(len(self))])
        slopes = np.diff(np.eye(len(self)), axis=0) / np.diff(centres)[:, None]
        return np.diff(slopes, axis=0) * (centres[-1] - centres[0])


def _raised(x: Scalar, knots: Float[ndarray, " knots"], left: Scalar, right: Scalar) -> Scalar:
    """A B-spline on its knots from the two of one degree less; 0/0 counts as 0."""
    rising, falling = knots[-2] - knots[0], knots[-1] - knots[1]
    up = mul((x - knots[0]) / rising, left) if rising > 0 else 0.0
    down = mul((knots[-1] - x) / falling, right) if falling > 0 else 0.0
    return up + down
