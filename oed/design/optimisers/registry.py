"""Which optimiser goes by which name; users add their own.

An optimiser is a function of a problem, a budget and a random generator that returns an
`OptimiserResult`. It is registered by `optimiser`, or found in the entry points of installed packages
under `oed.optimisers`, whose modules do the same.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from oed.design.optimisers.result import Budget, OptimiserResult
from oed.design.problem import DesignProblem
from oed.registered import Registered

# The best feasible motion found within the budget; every draw is from the generator.
Optimiser = Callable[[DesignProblem, Budget, np.random.Generator], OptimiserResult]
Given = TypeVar("Given", bound=Optimiser)

OWN = ("interior_point", "slsqp", "hopping", "evolution", "genetic", "random_search")
OPTIMISERS = Registered[Optimiser](
    "optimiser",
    "oed.optimisers",
    {name: f"oed.design.optimisers.{name}:optimise" for name in OWN},
)


def optimiser(name: str) -> Callable[[Given], Given]:
    """Register an optimiser under a name that commands accept; a later one replaces an earlier one."""
    return OPTIMISERS.add(name)


def find_optimiser(name: str) -> Optimiser:
    """The optimiser of a name.

    Raises:
        ValueError: If there is none.
    """
    return OPTIMISERS.find(name)
