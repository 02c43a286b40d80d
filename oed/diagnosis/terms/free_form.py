"""Nonparametric torque terms: what a library of names is measured against.

Cubic B-splines in one coordinate, or products of them in two, with or without the sign of a
joint's motion; outside the range that the data covered, they keep the value at its edge. And
any loop against a joint's position, as a sum of elastic sliders.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.interpolate import BSpline

from oed.dynamics.effects import Effect, Parameter, State
from oed.dynamics.effects.hysteresis import maxwell_elements
from oed.dynamics.scalars import Scalar

DEGREE = 3


@dataclass(frozen=True)
class Coordinate:
    """A coordinate that a free-form term may depend on.

    Attributes:
        kind: "q", "dq", "ddq" or "time".
        joint: Index of the joint; 0 for time.
        lower: Least value that the data covered.
        upper: Largest value.
        pieces: Polynomial pieces of the spline.
    """

    kind: str
    joint: int
    lower: float
    upper: float
    pieces: int

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
        """B-splines that add up to one; beyond the covered range they stay at its edge."""
        inner = np.linspace(self.lower, self.upper, self.pieces + 1)
        knots = np.concatenate([[self.lower] * DEGREE, inner, [self.upper] * DEGREE])
        inside = np.clip(self._values(state), self.lower, self.upper)
        return BSpline.design_matrix(inside, knots, DEGREE).toarray()

    def halved(self) -> Coordinate:
        """With pieces half as long."""
        return dataclasses.replace(self, pieces=2 * self.pieces)

    def _values(self, state: State) -> Float[ndarray, " samples"]:
        if self.kind == "time":
            return np.asarray(state.t, dtype=float)
        return np.asarray(getattr(state, self.kind)[self.joint], dtype=float)


@dataclass(frozen=True)
class Loop:
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

    def halved(self) -> Loop:
        """With twice the sliders."""
        return dataclasses.replace(self, functions=2 * self.functions)

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


@dataclass(frozen=True)
class Factor:
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

    def halved(self) -> Factor:
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


@dataclass(frozen=True)
class FreeForm(Effect):
    """A function of one or two coordinates on one joint.

    Attributes:
        joint: On which the torque acts.
        coordinates: One or two, of which a factor may be one.
        direction: Joint by the sign of whose velocity it is multiplied; None for none.
        mixing: Combinations of the basis functions that are its columns; None for each alone.
    """

    joint: int
    coordinates: tuple[Coordinate | Loop | Factor, ...]
    direction: int | None = None
    mixing: Float[ndarray, "functions columns"] | None = field(
        default=None, repr=False, compare=False
    )
    name = "free_form"

    @property
    def remembers(self) -> bool:
        """Whether it needs the motion that came before."""
        return any(isinstance(c, Loop) for c in self.coordinates)

    @property
    def varies(self) -> bool:
        """Whether it is a signal times a coefficient that varies with something else."""
        return any(isinstance(c, Factor) for c in self.coordinates)

    @property
    def label(self) -> str:
        """In words, such as "f(q_1, dq_2)", "f(q_2) dq_1" or "f(q_1) sgn(dq_1)"."""
        inside = ", ".join(c.name for c in self.coordinates if not isinstance(c, Factor))
        times = "".join(f" {c.name}" for c in self.coordinates if isinstance(c, Factor))
        turn = "" if self.direction is None else f" sgn(dq_{self.direction + 1})"
        return f"f({inside}){times}{turn}"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """One a column."""
        count = int(np.prod([c.functions for c in self.coordinates]))
        if self.mixing is not None:
            count = self.mixing.shape[1]
        tag = "_".join(c.name.replace(" ", "_") for c in self.coordinates)
        if self.direction is not None:
            tag += f"_s{self.direction + 1}"
        return tuple(
            Parameter(f"f_{self.joint + 1}[{tag}]_{k}", "N m", self.joint) for k in range(count)
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Names of the coordinates, the directing joint's velocity among them."""
        names = [name for c in self.coordinates for name in c.depends_on]
        turn = [] if self.direction is None else [f"dq_{self.direction + 1}"]
        return tuple(names + [name for name in turn if name not in names])

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """Products of the coordinates' basis functions."""
        product = self.coordinates[0].basis(state)
        for coordinate in self.coordinates[1:]:
            other = coordinate.basis(state)
            product = (product[:, :, None] * other[:, None, :]).reshape(len(product), -1)
        if self.direction is not None:
            product = product * np.asarray(state.sign(state.dq[self.direction]))[:, None]
        if self.mixing is not None:
            product = product @ self.mixing
        return [{self.joint: product[:, k]} for k in range(product.shape[1])]
