"""Which optimiser goes by which name; users add their own.

An optimiser is a function of a problem, a budget and a random generator that returns an
`OptimiserResult`. It is registered by `optimiser`, or found in the entry points of installed packages
under `oed.optimisers`, whose modules do the same.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from functools import cache
from importlib.metadata import entry_points
from typing import TypeVar

import numpy as np

from oed.design.optimisers.result import Budget, OptimiserResult
from oed.design.problem import DesignProblem

# The best feasible motion found within the budget; every draw is from the generator.
Optimiser = Callable[[DesignProblem, Budget, np.random.Generator], OptimiserResult]
Given = TypeVar("Given", bound=Optimiser)

ENTRY_POINTS = "oed.optimisers"
# Modules with a function `optimise`, imported when the first is asked for.
OWN = {
    name: f"oed.design.optimisers.{name}"
    for name in ("interior_point", "slsqp", "hopping", "evolution", "genetic", "random_search")
}
_optimisers: dict[str, Optimiser] = {}


def optimiser(name: str) -> Callable[[Given], Given]:
    """Register an optimiser under a name that commands accept; a later one replaces an earlier one."""
    if not name.strip():
        raise ValueError("an optimiser needs a name")

    def register(function: Given) -> Given:
        _optimisers[name] = function
        return function

    return register


def known_optimisers() -> tuple[str, ...]:
    """Names that can be asked for."""
    _load_entry_points()
    return tuple(dict.fromkeys((*OWN, *_optimisers)))


def find_optimiser(name: str) -> Optimiser:
    """The optimiser of a name.

    Raises:
        ValueError: If there is none.
    """
    if name not in known_optimisers():
        raise ValueError(f"no optimiser {name!r}; known are {', '.join(known_optimisers())}")
    if name in _optimisers:
        return _optimisers[name]
    return importlib.import_module(OWN[name]).optimise


@cache
def _load_entry_points() -> None:
    for point in entry_points(group=ENTRY_POINTS):
        point.load()
