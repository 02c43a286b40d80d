"""Nonparametric torque terms: what a library of names is measured against.

Functions of one coordinate, or products of functions of two, with or without the sign of a joint's
motion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import Effect, Parameter, State
from oed.dynamics.effects.arguments import Factor, Loop, VaryingInertia
from oed.dynamics.effects.coordinates import Coordinate
from oed.dynamics.effects.effect import Columns, Part
from oed.dynamics.scalars import Scalar, mul


@dataclass(frozen=True)
class SmoothTerm(Effect):
    """A function of one or two coordinates on one joint.

    Attributes:
        joint: On which the torque acts.
        coordinates: One or two, of which a factor may be one.
        direction: Joint by the sign of whose velocity it is multiplied; None for none.
    """

    joint: int
    coordinates: tuple[Coordinate | Loop | Factor | VaryingInertia, ...]
    direction: int | None = None
    name = "smooth_term"
    has_physics = False
    made_of = (Coordinate, Loop, Factor, VaryingInertia)

    @property
    def remembers(self) -> bool:
        """Whether it needs the motion that came before."""
        return any(isinstance(c, Loop) for c in self.coordinates)

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
        product, *others = self._bases(state)
        for other in others:
            product = (product[:, None] * other).reshape(-1, product.shape[1])
        return [{self.joint: column} for column in self._directed(product, state)]

    def torque(
        self, state: State, coefficients: Float[ndarray, " columns"]
    ) -> Mapping[int, Scalar]:
        """Summed up one coordinate after another: the products are many."""
        *others, last = self._bases(state)
        total = coefficients.reshape(-1, len(last)) @ last
        for other in reversed(others):
            total = np.sum(total.reshape(-1, *other.shape) * other, axis=1)
        return {self.joint: self._directed(total, state)[0]}

    @property
    def parts(self) -> tuple[Part, ...]:
        """By what it depends on."""
        kinds = {name.split("_")[0] for name in self.depends_on}
        part: Part = "inertia" if "ddq" in kinds else "position" if kinds <= {"q"} else "friction"
        return (part,) * len(self.parameters)

    @property
    def keeps(self) -> tuple[str, ...]:
        """What its coordinates keep."""
        return tuple(name for c in self.coordinates for name in c.keeps)

    def begin(self, state: State) -> Sequence[Scalar]:
        """What these remember at the first instant."""
        return [value for c in self.coordinates for value in c.begin(state)]

    def recall(
        self, state: State, memory: Sequence[Scalar], step: float
    ) -> tuple[Columns, Sequence[Scalar]]:
        """Products of the coordinates' basis functions at one instant."""
        product: list[Scalar] = [1.0]
        following: list[Scalar] = []
        start = 0
        for c in self.coordinates:
            stop = start + len(c.keeps)
            basis, kept = c.recall(state, memory[start:stop], step)
            product = [mul(one, other) for one in product for other in basis]
            following += kept
            start = stop
        if self.direction is not None:
            turn = state.sign(state.dq[self.direction])
            product = [mul(column, turn) for column in product]
        return [{self.joint: column} for column in product], following

    def _bases(self, state: State) -> list[Float[ndarray, "functions samples"]]:
        """Basis functions of each coordinate, each contiguous: all else is done to one of them."""
        return [np.ascontiguousarray(c.basis(state).T) for c in self.coordinates]

    def _directed(
        self, columns: Float[ndarray, "columns samples"], state: State
    ) -> Float[ndarray, "columns samples"]:
        """Columns by the direction of motion."""
        if self.direction is not None:
            columns = columns * state.sign(state.dq[self.direction])
        return columns
