"""What an optimiser may ask of a problem, and nothing else."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from numpy import ndarray


@runtime_checkable
class Box(Protocol):
    """Where the decision variables live."""

    @property
    def bounds(self) -> Float[ndarray, "size 2"]:
        """Lower and upper bound of every variable, finite."""
        ...


@runtime_checkable
class Problem(Protocol):
    """The part of `DesignProblem` that every optimiser uses; a test can be small."""

    @property
    def trajectory(self) -> Box:
        """The trajectory class, for its box."""
        ...

    def cost(self, z: Float[ndarray, " size"]) -> float:
        """The exact criterion, to be minimised; infinite where Lambda is singular."""
        ...

    def quick_repair(self, z: Float[ndarray, " size"]) -> Float[ndarray, " size"]:
        """A feasible point near z, cheaply."""
        ...

    def random_start(self, rng: np.random.Generator) -> Float[ndarray, " size"]:
        """A random feasible point."""
        ...
