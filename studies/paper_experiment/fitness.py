"""What the genetic algorithm calls fit: the paper's -J_k or J_d, or the logarithm of J_k."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.criteria import Criterion
from oed.design.optimisers.problem import Box
from oed.design.problem import DesignProblem

Fitness = Literal["-J_k", "-log10 J_k", "J_d"]
FITNESSES: tuple[Fitness, ...] = get_args(Fitness)


def criterion_of(fitness: Fitness) -> Criterion:
    """The criterion that it scores."""
    return "J_d" if fitness == "J_d" else "J_k"


@dataclass(frozen=True)
class LinearCondition:
    """A J_k problem whose cost is J_k itself, where `DesignProblem` has its logarithm.

    The same designs are best; but selection in proportion to fitness sees other proportions.
    """

    problem: DesignProblem

    @property
    def trajectory(self) -> Box:
        """The problem's own."""
        return self.problem.trajectory

    def cost(self, z: Float[ndarray, " size"]) -> float:
        """J_k, infinite where Lambda is singular."""
        return float(np.power(10.0, self.problem.cost(z)))

    def quick_repair(self, z: Float[ndarray, " size"]) -> Float[ndarray, " size"]:
        """The problem's own."""
        return self.problem.quick_repair(z)

    def random_start(self, rng: np.random.Generator) -> Float[ndarray, " size"]:
        """The problem's own."""
        return self.problem.random_start(rng)
