"""A problem with a known optimum, for every optimiser."""

from dataclasses import dataclass, field

import numpy as np
from numpy import ndarray


@dataclass(frozen=True)
class Box:
    bounds: ndarray


@dataclass
class Sphere:
    """|z - optimum|^2 on a box whose last variable is feasible up to 0.5 only."""

    trajectory: Box = field(
        default_factory=lambda: Box(np.array([[-1.0, 2.0], [0.0, 1.0], [-1.0, 1.0]]))
    )
    optimum: ndarray = field(default_factory=lambda: np.array([0.4, 0.7, 0.25]))
    asked: list[ndarray] = field(default_factory=list)

    def cost(self, z: ndarray) -> float:
        self.asked.append(z)
        return float(((z - self.optimum) ** 2).sum())

    def quick_repair(self, z: ndarray) -> ndarray:
        lower, upper = self.trajectory.bounds.T
        z = np.clip(z, lower, upper)
        return np.concatenate([z[:2], np.minimum(z[2:], 0.5)])

    def random_start(self, rng: np.random.Generator) -> ndarray:
        return self.quick_repair(rng.uniform(*self.trajectory.bounds.T))


class Singular(Sphere):
    """Infinite everywhere, like a motion that excites nothing."""

    def cost(self, z: ndarray) -> float:
        self.asked.append(z)
        return float("inf")
