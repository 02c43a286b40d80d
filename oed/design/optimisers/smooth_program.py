"""A smooth objective under sampled limits: what a solver of it is given and returns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.constraints import LimitConstraints

ValueAndGradient = Callable[[Float[ndarray, " size"]], tuple[float, Float[ndarray, " size"]]]
# Stands for an infinite objective, which a solver would not step back from: any cost in decades
# is far below.
SINGULAR = 1e3


class Spent(Exception):
    """Raised by an objective that will not be evaluated again: a solver ends where it is."""


@dataclass(frozen=True)
class LocalSolution:
    """Where a solver stopped.

    Attributes:
        z: (size,) the last point, which may violate a limit between the instants.
        evaluations: Of the objective, with its gradient where that was needed.
        is_converged: By the solver's own word.
        status: That word.
    """

    z: Float[ndarray, " size"]
    evaluations: int
    is_converged: bool
    status: str


@runtime_checkable
class ProgramSolver(Protocol):
    """Minimises a smooth objective under sampled limits."""

    def __call__(
        self,
        objective: ValueAndGradient,
        constraints: LimitConstraints,
        start: Float[ndarray, " size"],
        *,
        iterations: int,
        cpu_seconds: float = np.inf,
        is_warm: bool = False,
    ) -> LocalSolution:
        """A local solution; where it had come to, if the objective raises `Spent`."""
        ...
