"""Smooth stand-ins for an effect that no name fits: splines in one or two coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.effects.spline import Coordinate, Spline
from oed.dynamics.effects.thermal import since
from oed.dynamics.scalars import Scalar, mul

__all__ = ["Coordinate", "RepetitionTorque", "Spline", "SplineTorque"]


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

    def covered(self, state: State) -> Bool[ndarray, " samples"]:
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
class RepetitionTorque(Effect):
    """A torque of its own in each stretch of time but the first: drift without a name.

    Attributes:
        joint: Index of the joint.
        starts: Times since the first sample at which the later stretches begin [s].
        kind: A constant, Coulomb friction or viscous friction in each stretch.
        width: Velocity over which the sign turns [rad/s]; 0 for the exact sign.
    """

    joint: int
    starts: tuple[float, ...]
    kind: Literal["offset", "Fc", "Fv"] = "offset"
    width: float = 0.0
    name = "repetition_torque"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """One for each stretch but the first."""
        unit = "N m s/rad" if self.kind == "Fv" else "N m"
        return tuple(
            Parameter(f"{self.kind}_{self.joint + 1}_from_{start:g}s", unit, self.joint)
            for start in self.starts
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Time, and the velocity for friction."""
        return ("time",) if self.kind == "offset" else ("time", f"dq_{self.joint + 1}")

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """The constant or friction, within each stretch."""
        t = np.asarray(since(state.t, None), dtype=float)
        stretches = zip(self.starts, [*self.starts[1:], np.inf], strict=True)
        held = [np.asarray((t >= a) & (t < b), dtype=float) for a, b in stretches]
        factor = self._factor(state)
        gates = [gate if gate.ndim else float(gate) for gate in held]
        return [{self.joint: mul(gate, factor)} for gate in gates]

    def _factor(self, state: State) -> Scalar:
        if self.kind == "offset":
            return 1.0
        dq = state.dq[self.joint]
        return dq if self.kind == "Fv" else state.sign(dq, self.width)
