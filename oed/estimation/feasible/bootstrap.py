"""How far a feasible estimate would move on other data of the same kind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import t as student

from oed.estimation.feasible.data_factor import DataFactor
from oed.estimation.feasible.estimate import FeasibleEstimate
from oed.estimation.feasible.feasible_set import least_values
from oed.estimation.feasible.interior import SolverFailed
from oed.estimation.feasible.solve import SolverName, solve_problem
from oed.progress import told

MOSTLY_DATA = 0.5  # share from data above which a parameter counts as measured


@dataclass(frozen=True)
class Bootstrap:
    """Estimates from resampled blocks of the data.

    Attributes:
        estimate: (p,) parameters from all data.
        samples: (r, p) parameters of each resample, all of them feasible.
        from_data: (p,) share of each value that the data decide.
        least: (p,) what each parameter is at least, physically.
        failures: Resamples that no solver solved; they are in no interval.
        method: In words.
    """

    estimate: Float[ndarray, " p"]
    samples: Float[ndarray, "r p"]
    from_data: Float[ndarray, " p"]
    least: Float[ndarray, " p"]
    failures: int
    method: str

    def interval(self, level: float = 0.95) -> Float[ndarray, "p 2"]:
        """Intervals [lower, upper] at a confidence level; nan where the data decide less than half.

        As `interval_about`, and wider by 1 / `from_data`: the pull lets a value follow other data by
        that share alone, and holds it where the reference may be wrong.

        Raises:
            ValueError: If the level is not between 0 and 1.
        """
        share = np.where(self.from_data > MOSTLY_DATA, self.from_data, np.nan)[:, None]
        about, estimate = interval_about(self.estimate, self.samples, level), self.estimate[:, None]
        wider = estimate + (about - estimate) / share
        return np.maximum(wider, np.minimum(self.least, self.estimate)[:, None])

    @property
    def std(self) -> Float[ndarray, " p"]:
        """Standard deviation over resamples."""
        return self.samples.std(axis=0, ddof=1)


def interval_about(
    estimate: Float[ndarray, "..."], samples: Float[ndarray, "draws ..."], level: float
) -> Float[ndarray, "... 2"]:
    """Intervals [lower, upper] by draws, each of which holds the estimate.

    Percentiles at k/(r + 1), of which one more draw falls inside as often as they say. Fewer draws
    than have such percentiles give Student's t of their spread about the estimate (Efron and
    Tibshirani 1993, An Introduction to the Bootstrap, sections 12.2 and 13.3).

    Args:
        estimate: (...) values from all data.
        samples: (draws, ...) from resampled data, two or more.
        level: Between 0 and 1.

    Raises:
        ValueError: If the level is not between 0 and 1.
    """
    if not 0 < level < 1:
        raise ValueError(f"{level=} must lie between 0 and 1")
    if has_percentiles(len(samples), level):
        tail = 50 * (1 - level)
        lower, upper = np.percentile(samples, [tail, 100 - tail], axis=0, method="weibull")
    else:
        width = student.ppf((1 + level) / 2, len(samples) - 1) * samples.std(axis=0, ddof=1)
        lower, upper = estimate - width, estimate + width
    return np.stack([np.minimum(lower, estimate), np.maximum(upper, estimate)], axis=-1)


def has_percentiles(draws: int, level: float = 0.95) -> bool:
    """Whether a draw lies at or beyond each end of an interval: 39 at 95 %."""
    return (draws + 1) * (1 - level) / 2 > 1 - 1e-9


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
    interval is one-sided.

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
    rule = "percentiles" if has_percentiles(len(found)) else "Student's t of the spread"
    return Bootstrap(
        estimate=estimate.parameters,
        samples=np.array(found),
        from_data=estimate.from_data,
        least=least_values(estimate.model),
        failures=failures,
        method=f"{rule} of {len(found)} block-bootstrap estimates over {len(blocks)} blocks",
    )
