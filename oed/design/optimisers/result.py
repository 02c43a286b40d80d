"""What every optimiser is given and returns: a budget, a log of evaluations, a result."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.errors import NoUsableResult
from oed.progress import tell

KNOWN = 10  # digits of a cost: processors sum in other orders, and differ in the last of sixteen


def known_digits(cost: float) -> float:
    """A cost to the digits that it has on every processor.

    Mirror images of a motion cost the same but for rounding. What is chosen among them, and all
    that follows from the choice, would hang on the processor.
    """
    return float(f"{cost:.{KNOWN}g}")


@dataclass(frozen=True)
class Budget:
    """When to stop; None for no such bound.

    Attributes:
        evaluations: Evaluations of the criterion, one with its gradient counting as one.
        cpu_seconds: CPU time of this process [s].
    """

    evaluations: int | None = None
    cpu_seconds: float | None = None

    def __post_init__(self) -> None:
        if self.evaluations is None and self.cpu_seconds is None:
            raise ValueError("a budget needs a number of evaluations or of CPU seconds")


@dataclass(frozen=True)
class HistoryPoint:
    """An improvement: the best feasible cost after so many evaluations and seconds."""

    evaluations: int
    cpu_s: float
    cost: float


@dataclass(frozen=True)
class OptimiserResult:
    """What an optimiser found.

    Attributes:
        z: (size,) the best point.
        cost: The exact criterion there, as `DesignProblem.cost`.
        history: Improvements in order.
        evaluations: Evaluations spent.
        cpu_s: CPU time spent [s].
        status: One plain sentence.
    """

    z: Float[ndarray, " size"]
    cost: float
    history: tuple[HistoryPoint, ...]
    evaluations: int
    cpu_s: float
    status: str


@dataclass
class EvaluationLog:
    """Counts evaluations and keeps the best point: the one mutable thing of an optimiser.

    Attributes:
        budget: When to stop.
        evaluations: Spent so far.
        best_z: The best point offered, None before the first.
        best_cost: Its cost.
        history: Improvements in order.
    """

    budget: Budget
    evaluations: int = 0
    best_z: ndarray | None = None
    best_cost: float = np.inf
    history: list[HistoryPoint] = field(default_factory=list)
    started: float = field(default_factory=time.process_time)

    @property
    def cpu_s(self) -> float:
        """CPU time since the start [s]."""
        return time.process_time() - self.started

    @property
    def is_spent(self) -> bool:
        """Whether the budget is used up."""
        return self.left <= 0 or self.is_late

    @property
    def is_late(self) -> bool:
        """Whether its CPU time is used up."""
        return self.budget.cpu_seconds is not None and self.cpu_s >= self.budget.cpu_seconds

    @property
    def left(self) -> float:
        """Evaluations that the budget leaves; infinite where it does not bound them."""
        bound = self.budget.evaluations
        return np.inf if bound is None else max(0.0, float(bound - self.evaluations))

    def half(self) -> Budget:
        """Half of what the budget leaves, one evaluation at the least."""
        budget = self.budget
        return Budget(
            None if budget.evaluations is None else max(1, int(self.left) // 2),
            None if budget.cpu_seconds is None else max(0.0, budget.cpu_seconds - self.cpu_s) / 2,
        )

    def count(self, evaluations: int = 1) -> None:
        """Record evaluations that are offered to no one."""
        self.evaluations += evaluations
        tell("searching a motion", self.evaluations, self.budget.evaluations)

    def offer(self, z: Float[ndarray, " size"], cost: float) -> bool:
        """Keep a feasible point if it is the best so far, to `known_digits`; say whether it is."""
        if not cost < self.best_cost:
            return False
        if self.best_z is not None and known_digits(cost) == known_digits(self.best_cost):
            return False
        self.best_z, self.best_cost = np.array(z, dtype=float), float(cost)
        self.history.append(HistoryPoint(self.evaluations, self.cpu_s, self.best_cost))
        return True

    def evaluate(
        self, cost: Callable[[Float[ndarray, " size"]], float], z: Float[ndarray, " size"]
    ) -> float:
        """Evaluate a feasible point, count it and offer it."""
        value = cost(z)
        self.count()
        self.offer(z, value)
        return value

    def result(self, status: str) -> OptimiserResult:
        """The best point so far, as a result.

        Raises:
            NoUsableResult: If none was offered.
        """
        if self.best_z is None:
            raise NoUsableResult(
                "the optimiser came to no motion: raise --budget or --evaluations, or lengthen --horizon"
            )
        return OptimiserResult(
            self.best_z, self.best_cost, tuple(self.history), self.evaluations, self.cpu_s, status
        )
