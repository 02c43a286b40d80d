"""Smooth stand-ins for an effect that no name fits: splines in one or two coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.effects.thermal import since
from oed.dynamics.scalars import Scalar, magnitude, mul

DEGREE = 3
SMALLEST_SPAN = 1e-9  # a coordinate that moves less than this has no shape to find


@dataclass(frozen=True)
class Coordinate:
    """What a stand-in is a function of.

    Attributes:
        kind: Position, velocity, acceleration, their magnitudes' |dq|, the modelled torque,
            its magnitude, or time since the first sample.
        joint: Index of the joint; ignored for time.
        reference: Gives the torque, where that is the coordinate.
    """

    kind: Literal["q", "dq", "ddq", "|dq|", "tau", "|tau|", "time"]
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
        cls, coordinate: Coordinate, values: Float[ndarray, "samples"], pieces: int
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
    def knots(self) -> Float[ndarray, "knots"]:
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
        last = len(self) - 1  # the piece that is closed on the right
        values: list[Scalar] = [
            above + (x >= knots[i]) * (x < knots[i + 1]) * (1.0 - above)
            if i == last
            else (x >= knots[i]) * (x < knots[i + 1]) * (1.0 - above)
            if knots[i] < knots[i + 1]
            else 0.0
            for i in range(len(knots) - 1)
        ]
        for degree in range(1, DEGREE + 1):
            values = [
                _raised(x, knots, i, degree, values[i], values[i + 1])
                for i in range(len(values) - 1)
            ]
        return values

    def covered(self, state: State) -> Bool[ndarray, "samples"]:
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


@dataclass(frozen=True)
class SplineTorque(Effect):
    """A smooth function of one coordinate, or of two as products, added to a joint's torque.

    The coefficients need a ridge (`penalty`): splines follow noise and run away where data
    are thin. Outside the coverage the nearest covered value is held.

    Attributes:
        joint: Index of the joint whose torque it is.
        splines: One or two.
        with_direction: Whether it is multiplied by sgn(dq_j), like friction.
        kept: Basis functions that the data touch, None for all.
        width: Velocity over which that sign turns [rad/s]; 0 for the exact sign.
    """

    joint: int
    splines: tuple[Spline, ...]
    with_direction: bool = False
    kept: tuple[int, ...] | None = None
    width: float = 0.0
    name = "nonparametric"

    def __post_init__(self) -> None:
        if len(self.splines) not in (1, 2):
            raise ValueError(f"{len(self.splines)} splines: one or two coordinates")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Coefficients of the basis functions."""
        where = "*".join(spline.coordinate.name for spline in self.splines)
        return tuple(
            Parameter(f"spline_{where}_{k + 1}_on_{self.joint + 1}", "N m", self.joint)
            for k in self._kept
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The splines' coordinates, and the velocity if it turns the sign."""
        names = [spline.coordinate.name for spline in self.splines]
        direction = [f"dq_{self.joint + 1}"] if self.with_direction else []
        return tuple(dict.fromkeys([*names, *direction]))

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """The basis functions that are kept."""
        factor: Scalar = 1.0
        if self.with_direction:
            factor = state.sign(state.dq[self.joint], self.width)
        products = self._products(state)
        return [{self.joint: mul(products[k], factor)} for k in self._kept]

    def restricted(self, state: State, least: float = 1.0) -> SplineTorque:
        """This effect with only the basis functions that the data touch.

        Args:
            state: Of the data.
            least: Smallest sum of a basis function over the samples.
        """
        sums = [float(np.sum(product)) for product in self._products(state)]
        return replace(self, kept=tuple(k for k, weight in enumerate(sums) if weight >= least))

    def covered(self, state: State) -> Bool[ndarray, "samples"]:
        """Where every coordinate is within its coverage, and in a cell that the data touch."""
        inside = np.logical_and.reduce([spline.covered(state) for spline in self.splines])
        products = self._products(state)
        touched = np.sum([np.broadcast_to(products[k], inside.shape) for k in self._kept], axis=0)
        return inside & (touched > 0.5)

    def penalty(self, ridge: float, roughness: float) -> Float[ndarray, "rows columns"]:
        """Rows to append to the regressor against a zero target, in units of torque.

        Args:
            ridge: Weight of each coefficient.
            roughness: Weight of second differences along each coordinate.
        """
        rough = [spline.roughness() for spline in self.splines]
        if len(self.splines) == 2:
            eyes = [np.eye(len(spline)) for spline in self.splines]
            rough = [np.kron(rough[0], eyes[1]), np.kron(eyes[0], rough[1])]
        width = rough[0].shape[1]
        rows = np.concatenate([ridge * np.eye(width), *(roughness * part for part in rough)])
        return rows[:, list(self._kept)]

    @property
    def _kept(self) -> tuple[int, ...]:
        if self.kept is not None:
            return self.kept
        return tuple(range(int(np.prod([len(spline) for spline in self.splines]))))

    def _products(self, state: State) -> list[Scalar]:
        first = self.splines[0].basis(state)
        if len(self.splines) == 1:
            return first
        second = self.splines[1].basis(state)
        return [mul(a, b) for a in first for b in second]


@dataclass(frozen=True)
class RepetitionOffset(Effect):
    """A constant on a joint in each stretch of time, less the first: drift without a name.

    Attributes:
        joint: Index of the joint.
        starts: Times since the first sample at which the later stretches begin [s].
    """

    joint: int
    starts: tuple[float, ...]
    name = "repetition_offset"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """One for each stretch but the first."""
        return tuple(
            Parameter(f"offset_{self.joint + 1}_from_{start:g}s", "N m", self.joint)
            for start in self.starts
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Time."""
        return ("time",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """1 within each stretch."""
        t = np.asarray(since(state.t, None), dtype=float)
        ends = [*self.starts[1:], np.inf]
        stretches = zip(self.starts, ends, strict=True)
        return [{self.joint: 1.0 * ((t >= a) & (t < b))} for a, b in stretches]


def _raised(
    x: Scalar,
    knots: Float[ndarray, "knots"],
    i: int,
    degree: int,
    left: Scalar,
    right: Scalar,
) -> Scalar:
    """B-spline i of a degree from those of one degree less; 0/0 counts as 0."""
    rising, falling = knots[i + degree] - knots[i], knots[i + degree + 1] - knots[i + 1]
    up = mul((x - knots[i]) / rising, left) if rising > 0 else 0.0
    down = mul((knots[i + degree + 1] - x) / falling, right) if falling > 0 else 0.0
    return up + down
