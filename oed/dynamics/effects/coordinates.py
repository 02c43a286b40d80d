"""What a smooth term may depend on, and the functions of it that the term is made of.

Cubic B-splines in one coordinate; outside the range that the data covered, they keep the value at
its edge.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.interpolate import BSpline

from oed.dynamics.effects import State
from oed.dynamics.effects.splines import spline_values
from oed.dynamics.effects.thermal import since
from oed.dynamics.scalars import Scalar, asinh, sub, within

DEGREE = 3
CROWDING = 0.1  # of a coordinate's largest value, about which crowded pieces crowd


class Argument:
    """What a smooth term is a function of, one instant after another; most keep nothing."""

    @property
    def keeps(self) -> tuple[str, ...]:
        """What it keeps from one instant to the next, by name."""
        return ()

    def begin(self, state: State) -> Sequence[Scalar]:  # noqa: ARG002  # of those that remember
        """What it keeps at the first instant."""
        return ()

    def recall(
        self, state: State, memory: Sequence[Scalar], step: float
    ) -> tuple[list[Scalar], Sequence[Scalar]]:
        """Basis functions at one instant, and the memory at the next; as of `Effect.recall`."""
        raise NotImplementedError


@dataclass(frozen=True)
class Coordinate(Argument):
    """A coordinate that a smooth term may depend on.

    Attributes:
        kind: "q", "dq", "ddq" or "time".
        joint: Index of the joint; 0 for time.
        lower: Least value that the data covered.
        upper: Largest value.
        pieces: Polynomial pieces of the spline.
        crowding: Value below which the pieces crowd: they are even in asinh of the coordinate
            over it. None for pieces that are even in the coordinate.
        start: Origin of time [s]; None for the first sample of each recording.
        from_rest: Whether the functions vanish where the coordinate is zero, so that a constant
            torque is none of them.
    """

    kind: str
    joint: int
    lower: float
    upper: float
    pieces: int
    crowding: float | None = None
    start: float | None = 0.0
    from_rest: bool = False

    @property
    def name(self) -> str:
        """Such as "dq_2" (joints from 1), or "time"."""
        return "time" if self.kind == "time" else f"{self.kind}_{self.joint + 1}"

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Itself."""
        return (self.name,)

    @property
    def functions(self) -> int:
        """Number of basis functions."""
        return self.pieces + DEGREE

    def basis(self, state: State) -> Float[ndarray, "samples functions"]:
        """B-splines that add up to one; beyond the covered range they stay at its edge.

        From rest, each less its value there.
        """
        splines = self._splines(self.values(state))
        return splines - self._splines(np.zeros(1)) if self.from_rest else splines

    def _splines(self, values: Float[ndarray, " samples"]) -> Float[ndarray, "samples functions"]:
        inside = np.clip(values, self.lower, self.upper)
        lower, upper = self._knots[[0, -1]]
        stretched = np.clip(self._stretched(inside), lower, upper)
        # None lies beyond the knots; to have that checked takes longer than all else.
        return BSpline.design_matrix(stretched, self._knots, DEGREE, extrapolate=True).toarray()

    @property
    def keeps(self) -> tuple[str, ...]:
        """Time since the start [s], where it is one."""
        return ("time",) if self.kind == "time" else ()

    def begin(self, state: State) -> Sequence[Scalar]:  # noqa: ARG002  # whatever it is
        """No time has gone by."""
        return (0.0,) * len(self.keeps)

    def recall(
        self, state: State, memory: Sequence[Scalar], step: float
    ) -> tuple[list[Scalar], Sequence[Scalar]]:
        """B-splines, as `basis` has them."""
        is_time = self.kind == "time"
        value = memory[0] if is_time else getattr(state, self.kind)[self.joint]
        splines = self.spline_values(value)
        if self.from_rest:
            at_rest = self._splines(np.zeros(1))[0].tolist()
            splines = [sub(own, rest) for own, rest in zip(splines, at_rest, strict=True)]
        return splines, (value + step,) if is_time else ()

    def spline_values(self, value: Scalar, *, derivative: int = 0) -> list[Scalar]:
        """B-splines, even ones with their derivatives, at one value; as at the edge beyond it."""
        inside = within(value, self.lower, self.upper)
        if self.crowding is not None:
            inside = asinh(inside * (1 / self.crowding))
        return spline_values(self._knots, DEGREE, inside, derivative=derivative)

    def slopes(self, state: State) -> Float[ndarray, "samples functions"]:
        """Derivatives of the B-splines, even ones; zero beyond the covered range."""
        values = self.values(state)
        splines = BSpline(self._knots, np.eye(self.functions), DEGREE).derivative()
        covered = (values >= self.lower) & (values <= self.upper)
        return splines(np.clip(values, self.lower, self.upper)) * covered[:, None]

    @property
    def _knots(self) -> Float[ndarray, " knots"]:
        lower, upper = self._stretched(np.array([self.lower, self.upper]))
        inner = np.linspace(lower, upper, self.pieces + 1)
        return np.concatenate([[lower] * DEGREE, inner, [upper] * DEGREE])

    def crowded(self, share: float = CROWDING) -> Coordinate:
        """With its pieces closer together about zero, as friction changes with speed.

        Args:
            share: Of its largest value, below which they crowd.
        """
        return dataclasses.replace(self, crowding=share * max(abs(self.lower), abs(self.upper)))

    def values(self, state: State) -> Float[ndarray, " samples"]:
        """The coordinate itself."""
        if self.kind == "time":
            return np.asarray(since(state.t, self.start), dtype=float)
        return np.asarray(getattr(state, self.kind)[self.joint], dtype=float)

    def _stretched(self, values: Float[ndarray, " count"]) -> Float[ndarray, " count"]:
        return values if self.crowding is None else np.arcsinh(values / self.crowding)
