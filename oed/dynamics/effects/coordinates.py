"""What a free-form term may depend on, and the functions of it that the term is made of.

Cubic B-splines in one coordinate; outside the range that the data covered, they keep the value at
its edge. Any loop against a joint's position, as a sum of elastic sliders. Signals in proportion to
which a function of something else acts, and inertia that changes with position.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.interpolate import BSpline

from oed.dynamics.effects import State
from oed.dynamics.effects.hysteresis import (
    maxwell_elements,
    moved_elements,
    remembered_elements,
)
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.effects.splines import spline_values
from oed.dynamics.effects.thermal import since
from oed.dynamics.scalars import Scalar, add, asinh, at_least, mul, power, sub, within

DEGREE = 3
CROWDING = 0.1  # of a coordinate's largest value, about which crowded pieces crowd


class Argument:
    """What a free-form term is a function of, one instant after another; most keep nothing."""

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
    """A coordinate that a free-form term may depend on.

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

    def refined(self, pieces: int) -> Coordinate:
        """With at least so many pieces."""
        return dataclasses.replace(self, pieces=max(pieces, self.pieces))

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


@dataclass(frozen=True)
class Loop(Argument):
    """What a joint's position drags: torque that lags behind each reversal over some distance.

    Elastic sliders (stop operators) of many break-away distances add up to any loop of
    Prandtl and Ishlinskii (Brokate and Sprekels 1996, "Hysteresis and Phase Transitions").

    Attributes:
        joint: Whose position drags.
        shortest: Break-away distance of the first slider [rad or m].
        longest: Of the last [rad or m].
        functions: Number of sliders, their distances in geometric steps.
    """

    joint: int
    shortest: float
    longest: float
    functions: int
    kind = "loop"

    def refined(self, pieces: int) -> Loop:
        """With at least so many sliders."""
        return dataclasses.replace(self, functions=max(pieces, self.functions))

    @property
    def name(self) -> str:
        """Such as "loop of q_2"."""
        return f"loop of q_{self.joint + 1}"

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Position, by its reversals, and direction."""
        return (f"q_{self.joint + 1}", f"dq_{self.joint + 1}")

    def basis(self, state: State) -> Float[ndarray, "samples functions"]:
        """Deflection of each slider, from -1 to 1, relaxed at the start.

        Raises:
            ValueError: If the state is symbolic.
        """
        q = np.ascontiguousarray(state.motion(self.name).q[:, self.joint])
        distances = np.geomspace(self.shortest, self.longest, self.functions)
        return np.stack([maxwell_elements(q, np.array([d])) for d in distances], axis=1)

    @property
    def keeps(self) -> tuple[str, ...]:
        """Where the joint was, and the deflection of each slider."""
        return remembered_elements(self.joint, self.functions)

    def begin(self, state: State) -> Sequence[Scalar]:
        """All of them relaxed."""
        return (state.q[self.joint], *[0.0] * self.functions)

    def recall(
        self,
        state: State,
        memory: Sequence[Scalar],
        step: float,  # noqa: ARG002  # the way counts, not the time
    ) -> tuple[list[Scalar], Sequence[Scalar]]:
        """Deflection of each slider."""
        q = state.q[self.joint]
        distances = np.geomspace(self.shortest, self.longest, self.functions)
        z = moved_elements(q - memory[0], memory[1:], distances)
        return z, (q, *z)


@dataclass(frozen=True)
class Factor(Argument):
    """A signal in proportion to which a function of something else acts.

    With it a term is linear in this signal, its coefficient varying (Hastie and Tibshirani
    1993, "Varying-coefficient models", JRSS B 55(4)): far fewer parameters than a function of
    both coordinates, and sure beyond the range that was covered.

    Attributes:
        kind: "dq" or "ddq".
        joint: Index of the joint.
    """

    kind: str
    joint: int
    functions = 1

    def refined(self, _pieces: int) -> Factor:
        """Itself: a line has no pieces."""
        return self

    @property
    def name(self) -> str:
        """Such as "dq_2" (joints from 1)."""
        return f"{self.kind}_{self.joint + 1}"

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Itself."""
        return (self.name,)

    def basis(self, state: State) -> Float[ndarray, "samples functions"]:
        """The signal."""
        values = np.asarray(getattr(state, self.kind)[self.joint], dtype=float)
        return values[:, None]

    def recall(
        self,
        state: State,
        memory: Sequence[Scalar],  # noqa: ARG002  # it keeps nothing
        step: float,  # noqa: ARG002
    ) -> tuple[list[Scalar], Sequence[Scalar]]:
        """The signal."""
        return [getattr(state, self.kind)[self.joint]], ()


@dataclass(frozen=True)
class OtherTorque(Argument):
    """A share of another joint's torque: a sensor that feels it, an axis that is not straight.

    Attributes:
        joint: Index of the other joint.
        reference: Predicts its torque.
        exponent: 2 where it is the square that shows.
    """

    joint: int
    reference: ReferenceTorque = field(repr=False, compare=False)
    exponent: int = 1
    functions = 1
    kind = "tau"

    def refined(self, _pieces: int) -> OtherTorque:
        """Itself: a share has no pieces."""
        return self

    @property
    def name(self) -> str:
        """Such as "tau_2" (joints from 1)."""
        return self.depends_on[0] + ("" if self.exponent == 1 else f"^{self.exponent}")

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The torque."""
        return (f"tau_{self.joint + 1}",)

    def basis(self, state: State) -> Float[ndarray, "samples functions"]:
        """The torque to its exponent."""
        torque = np.asarray(self.reference.total(state)[self.joint], dtype=float)
        return torque[:, None] ** self.exponent

    @property
    def keeps(self) -> tuple[str, ...]:
        """What the torque does."""
        return self.reference.keeps

    def begin(self, state: State) -> Sequence[Scalar]:
        """What it keeps at the first instant."""
        return self.reference.begin(state)

    def recall(
        self, state: State, memory: Sequence[Scalar], step: float
    ) -> tuple[list[Scalar], Sequence[Scalar]]:
        """The torque to its exponent."""
        now, following = self.reference.recall(state, memory, step)
        return [power(now.total(state)[self.joint], self.exponent)], following


@dataclass(frozen=True)
class VaryingInertia(Argument):
    """Inertia that changes with a joint's position: J(q) ddq + J'(q) dq^2 / 2.

    A crank, a linkage or a cam carries what its motor turns in this way. Both parts follow from
    one energy J dq^2 / 2, so that they share their coefficients.

    Attributes:
        position: Of the joint, with the pieces of J.
    """

    position: Coordinate
    kind = "inertia"

    def refined(self, pieces: int) -> VaryingInertia:
        """With at least so many pieces."""
        return VaryingInertia(self.position.refined(pieces))

    @property
    def functions(self) -> int:
        """Number of basis functions."""
        return self.position.functions

    @property
    def name(self) -> str:
        """Such as "inertia over q_2"."""
        return f"inertia over {self.position.name}"

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Position, speed and acceleration of the joint."""
        joint = self.position.joint + 1
        return (f"q_{joint}", f"dq_{joint}", f"ddq_{joint}")

    def basis(self, state: State) -> Float[ndarray, "samples functions"]:
        """Torque of each spline's inertia."""
        dq, ddq = (
            np.asarray(getattr(state, kind)[self.position.joint], dtype=float)[:, None]
            for kind in ("dq", "ddq")
        )
        slope = self.position.slopes(state)
        return self.position.basis(state) * ddq + slope * dq**2 / 2

    def recall(
        self,
        state: State,
        memory: Sequence[Scalar],  # noqa: ARG002  # it keeps nothing
        step: float,  # noqa: ARG002
    ) -> tuple[list[Scalar], Sequence[Scalar]]:
        """Torque of each spline's inertia."""
        own = self.position
        q, dq, ddq = (x[own.joint] for x in (state.q, state.dq, state.ddq))
        covered = sub(at_least(q, own.lower), at_least(q, np.nextafter(own.upper, np.inf)))
        half = mul(covered, dq * dq * 0.5)
        pairs = zip(own.spline_values(q), own.spline_values(q, derivative=1), strict=True)
        return [add(mul(value, ddq), mul(slope, half)) for value, slope in pairs], ()
