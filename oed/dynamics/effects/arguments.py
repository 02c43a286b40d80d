"""What else than a coordinate a smooth term may depend on.

Any loop against a joint's position, as a sum of elastic sliders. Signals in proportion to which a
function of something else acts, and inertia that changes with position.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import State
from oed.dynamics.effects.coordinates import Argument, Coordinate
from oed.dynamics.effects.hysteresis import (
    maxwell_elements,
    moved_elements,
    remembered_elements,
)
from oed.dynamics.scalars import Scalar, add, at_least, mul, sub


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
        distances = np.geomspace(self.shortest, self.longest, self.functions)
        return maxwell_elements(state.motion(self.name).q[:, self.joint], distances)

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
