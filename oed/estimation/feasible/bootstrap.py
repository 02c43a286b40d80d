"""How far a feasible estimate would move on other data of the same kind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.feasible.data_factor import DataFactor
from oed.estimation.feasible.estimate import FeasibleEstimate
from oed.estimation.feasible.interior import SolverFailed
from oed.estimation.feasible.solve import SolverName, solve_problem
from oed.progress import told


@dataclass(frozen=True)
class Bootstrap:
    """Estimates from resampled blocks of the data.

    Attributes:
        samples: (r, p) parameters of each resample, all of them feasible.
        failures: Resamples that no solver solved; they are in no interval.
        method: In words.
    """

    samples: Float[ndarray, "r p"]
    failures: int
    method: str

    def interval(self, level: float = 0.95) -> Float[ndarray, "p 2"]:
        """Percentile intervals [lower, upper] at a confidence level.

        Raises:
            ValueError: If the level is not between 0 and 1.
        """
        if not 0 < level < 1:
            raise ValueError(f"{level=} must lie between 0 and 1")
        tail = 50 * (1 - level)
        return np.percentile(self.samples, [tail, 100 - tail], axis=0).T

    @property
    def std(self) -> Float[ndarray, " p"]:
        """Standard deviation over resamples."""
        return self.samples.std(axis=0, ddof=1)


def bootstrap(
    estimate: FeasibleEstimate,
    blocks: Sequence[DataFactor],
    rng: np.random.Generator,
    *,
    resamples: int = 60,
    solvers: tuple[SolverName, ...] = ("clarabel", "barrier"),
) -> Bootstrap:
    """Draw blocks with replacement and estimate again, demands and pull as they are.

    A block bootstrap (Kuensch 1989): errors may be correlated within a block, and the intervals
    respect the demands, which a covariance does not. Where a demand is active the
    interval is one-sided; where the pull decides a value, it shows no uncertainty of that value.

    Args:
        estimate: From all blocks.
        blocks: Repetitions or consecutive pieces, each longer than the errors' correlation.
        rng: Of the draws.
        resamples: Number of draws.
        solvers: To try, in this order.

    Raises:
        ValueError: If there are fewer than two blocks.
        SolverFailed: If fewer than half of the resamples could be solved.
    """
    if len(blocks) < 2:
        raise ValueError(f"{len(blocks)} block cannot be resampled")
    found = []
    for _ in told(range(resamples), "intervals, by resampling"):
        drawn = rng.integers(len(blocks), size=len(blocks))
        problem = estimate.problem.with_data(DataFactor.join([blocks[k] for k in drawn]))
        try:
            found.append(problem.coordinates.parameters(solve_problem(problem, solvers).x))
        except SolverFailed:
            continue
    failures = resamples - len(found)
    if len(found) < max(2, resamples / 2):
        raise SolverFailed(f"{failures} of {resamples} resamples failed", ())
    return Bootstrap(
        samples=np.array(found),
        failures=failures,
        method=f"percentiles of {len(found)} block-bootstrap estimates over {len(blocks)} blocks",
    )
