"""Nonparametric torque terms: what a library of names is measured against.

Functions of one coordinate, or products of functions of two, with or without the sign of a joint's
motion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import Effect, Parameter, State
from oed.dynamics.effects.arguments import Factor, Loop, OtherTorque, VaryingInertia
from oed.dynamics.effects.coordinates import Coordinate
from oed.dynamics.effects.effect import Columns, Part
from oed.dynamics.effects.visited import Visited
from oed.dynamics.scalars import Scalar, dot, mul


@dataclass(frozen=True)
class FreeForm(Effect):
    """A function of one or two coordinates on one joint.

    Attributes:
        joint: On which the torque acts.
        coordinates: One or two, of which a factor may be one.
        direction: Joint by the sign of whose velocity it is multiplied; None for none.
        mixing: Combinations of the basis functions that are its columns; None for each alone.
        visited: Region of `places` beyond which it ends; None if it carries on as at its edge.
    """

    joint: int
    coordinates: tuple[Coordinate | Loop | Factor | VaryingInertia | OtherTorque, ...]
    direction: int | None = None
    mixing: Float[ndarray, "functions columns"] | None = field(
        default=None, repr=False, compare=False
    )
    visited: Visited | None = field(default=None, repr=False, compare=False)
    name = "free_form"
    has_physics = False
    made_of = (Coordinate, Loop, Factor, VaryingInertia, OtherTorque, Visited)

    @property
    def remembers(self) -> bool:
        """Whether it needs the motion that came before."""
        return any(isinstance(c, Loop) for c in self.coordinates)

    @property
    def varies(self) -> bool:
        """Whether it is a signal times a coefficient that varies with something else."""
        return any(isinstance(c, Factor | VaryingInertia) for c in self.coordinates)

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

    def places(self, state: State) -> Float[ndarray, "samples places"]:
        """Values of the arm's coordinates that it is a function of."""
        own = [c for c in self.coordinates if isinstance(c, Coordinate) and c.kind != "time"]
        values = [c.values(state) for c in own]
        return np.stack(values, axis=1) if values else np.zeros((len(state.t), 0))

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
        if self.mixing is not None:
            product = self.mixing.T @ product
        return [{self.joint: column} for column in self._directed(product, state)]

    def torque(
        self, state: State, coefficients: Float[ndarray, " columns"]
    ) -> Mapping[int, Scalar]:
        """Summed up one coordinate after another: the products are many."""
        *others, last = self._bases(state)
        sizes = coefficients if self.mixing is None else self.mixing @ coefficients
        total = sizes.reshape(-1, len(last)) @ last
        for other in reversed(others):
            total = np.sum(total.reshape(-1, *other.shape) * other, axis=1)
        return {self.joint: self._directed(total, state)[0]}

    @property
    def offline(self) -> str:  # pyright: ignore[reportIncompatibleVariableOverride]
        """A table of where motions have been has no formula."""
        return "" if self.visited is None else "it ends where no recording has been, by a table"

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
        if self.mixing is not None:
            columns = self.mixing.T.tolist()
            product = [dot(column, product) for column in columns]
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
        """Columns by the direction of motion, ended where no motion has been."""
        if self.direction is not None:
            columns = columns * state.sign(state.dq[self.direction])
        if self.visited is not None:
            columns = columns * self.visited.weight(self.places(state))
        return columns
