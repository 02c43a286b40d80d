"""What a search may add: columns given shapes, a prior, and the place where it acts."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.catalogue import CatalogueEntry, Context, Shape, Target
from oed.dynamics.effects.effect import Effect
from oed.dynamics.effects.smooth_term import SmoothTerm
from oed.dynamics.torque_model import TorqueModel

Values = tuple[float, ...]
Coefficients = Float[ndarray, " columns"]


class Candidate(ABC):
    """A term that a model may have."""

    @property
    @abstractmethod
    def label(self) -> str:
        """Unique, in words."""

    @property
    @abstractmethod
    def kind(self) -> str:
        """What it is, wherever it acts."""

    @property
    @abstractmethod
    def joint(self) -> int | None:
        """Where it acts; None for the whole arm."""

    @property
    @abstractmethod
    def is_named(self) -> bool:
        """Whether it claims physics."""

    @property
    def unit_coefficient(self) -> bool:
        """Whether its size is in its shapes alone."""
        return False

    @property
    def acts_on_model(self) -> bool:
        """Whether it changes the whole model, once its size is known."""
        return False

    @property
    def holds(self) -> tuple[str, ...]:
        """Names of effects that are this one with parameters left out."""
        return ()

    def size_in(
        self,
        base: TorqueModel,  # noqa: ARG002
        model: TorqueModel,  # noqa: ARG002
    ) -> Coefficients | None:
        """Size of what was installed in a model in steps; None where the steps add up."""
        return None

    @property
    @abstractmethod
    def changes(self) -> bool:
        """Whether it makes repetitions of one motion differ."""

    @abstractmethod
    def shapes(self, context: Context) -> tuple[Shape, ...]:
        """Nonlinear parameters with their ranges."""

    @abstractmethod
    def grid(self, context: Context) -> Iterator[Values]:
        """Shapes of a first scan."""

    @abstractmethod
    def effect(self, context: Context, values: Values) -> Effect:
        """Its columns."""

    @abstractmethod
    def excluded(self, context: Context, values: Values, sizes: Coefficients) -> str | None:
        """Why its prior has no support there; None where it has."""

    @abstractmethod
    def precision(self, columns: int) -> Float[ndarray, "columns columns"] | None:
        """Of its prior but for a factor; None for the unit information of the data."""


@dataclass(frozen=True)
class NamedCandidate(Candidate):
    """An effect of the catalogue at one place.

    Attributes:
        entry: The effect.
        target: Joint, pair of joints, or None for the arm.
    """

    entry: CatalogueEntry
    target: Target

    @property
    def label(self) -> str:
        """Such as "stribeck@2"."""
        if self.target is None:
            return self.entry.name
        if isinstance(self.target, tuple):
            return f"{self.entry.name}@{self.target[0] + 1}<{self.target[1] + 1}"
        return f"{self.entry.name}@{self.target + 1}"

    @property
    def kind(self) -> str:
        """Name of the effect."""
        return self.entry.name

    @property
    def joint(self) -> int | None:
        """Of the target."""
        return self.target[0] if isinstance(self.target, tuple) else self.target

    @property
    def is_named(self) -> bool:
        """It is."""
        return True

    @property
    def unit_coefficient(self) -> bool:
        """As its entry says."""
        return self.entry.unit_coefficient

    @property
    def acts_on_model(self) -> bool:
        """Where its columns are a first order."""
        return self.entry.install is not None

    @property
    def changes(self) -> bool:
        """As its entry says."""
        return self.entry.between_repetitions

    def shapes(self, context: Context) -> tuple[Shape, ...]:
        """As its entry says."""
        return self.entry.shapes_for(context, self.target)

    def grid(self, context: Context) -> Iterator[Values]:
        """All combinations, and what the entry has besides."""
        yield from product(*(shape.grid for shape in self.shapes(context)))
        yield from self.entry.further(context)

    def effect(self, context: Context, values: Values) -> Effect:
        """As its entry builds it."""
        return self.entry.build(context, self.target, values)

    def excluded(self, context: Context, values: Values, sizes: Coefficients) -> str | None:
        """As its entry says."""
        return self.entry.plausible(context, self.target, values, sizes)

    def precision(self, columns: int) -> None:  # of any number
        """Unit information."""

    @property
    def holds(self) -> tuple[str, ...]:
        """As its entry says."""
        return self.entry.holds

    def size_in(self, base: TorqueModel, model: TorqueModel) -> Coefficients | None:
        """As its entry reads it off the model."""
        return None if self.entry.size_in is None else self.entry.size_in(base, model)

    def install(self, context: Context, values: Values, sizes: Coefficients) -> TorqueModel:
        """The context's model with it."""
        return self.entry.apply(context, self.target, values, sizes)


@dataclass(frozen=True)
class SmoothCandidate(Candidate):
    """A function of one or two coordinates that claims no physics.

    Attributes:
        term: Its basis functions.
    """

    term: SmoothTerm

    @property
    def label(self) -> str:
        """Such as "f(q_1)@2"."""
        pieces = "x".join(str(c.functions) for c in self.term.coordinates)
        return f"{self.term.label}[{pieces}]@{self.term.joint + 1}"

    @property
    def kind(self) -> str:
        """Of all smooth terms alike."""
        return "smooth term"

    @property
    def joint(self) -> int | None:
        """Where it acts."""
        return self.term.joint

    @property
    def is_named(self) -> bool:
        """It is not."""
        return False

    @property
    def changes(self) -> bool:
        """Where time is one of its coordinates."""
        return "time" in self.term.depends_on

    def shapes(self, context: Context) -> tuple[Shape, ...]:  # noqa: ARG002  # the same for all
        """None."""
        return ()

    def grid(self, context: Context) -> Iterator[Values]:  # noqa: ARG002
        """Once."""
        yield ()

    def effect(self, context: Context, values: Values) -> Effect:  # noqa: ARG002
        """Itself."""
        return self.term

    def excluded(self, context: Context, values: Values, sizes: Coefficients) -> str | None:  # noqa: ARG002
        """Never."""
        return None

    def precision(self, columns: int) -> Float[ndarray, "columns columns"]:
        """First differences along each coordinate (Eilers and Marx 1996, Statistical Science 11(2)).

        Where no row was, the function lies between what it is around (Currie, Durban and Eilers
        2004, Statistical Modelling 4(4)); second differences would go on along its slope.
        """
        counts = [c.functions for c in self.term.coordinates]
        result = np.zeros((columns, columns))
        for k, count in enumerate(counts):
            steps = np.diff(np.eye(count), axis=0)
            before, after = int(np.prod(counts[:k])), int(np.prod(counts[k + 1 :]))
            result += np.kron(np.kron(np.eye(before), steps.T @ steps), np.eye(after))
        return result
