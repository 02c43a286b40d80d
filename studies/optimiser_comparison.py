"""Optimisers held against one another, seed by seed, at one budget.

The outcomes of `judge` and what would refute a ranking were written before the runs were made.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from oed.design.optimisers.result import HistoryPoint
from oed.design.optimisers.target_hits import cost_at, read_history
from studies.case_runner import FAILED

LEVEL = 0.95  # of all pairs of one budget together
# In J_k, or in the information about every parameter: as much as one percent more samples would tell.
MATTERS = 0.01


@dataclass(frozen=True)
class Run:
    """One run.

    Attributes:
        optimiser: Its name.
        seed: Of its draws.
        seconds: CPU time that it was given [s].
        history: The best motion so far, in order of time.
        status: What it did.
        violation: Worst certified violation of the motion that it ended with.
    """

    optimiser: str
    seed: int
    seconds: float
    history: tuple[HistoryPoint, ...]
    status: str
    violation: float


@dataclass(frozen=True)
class Cell:
    """A problem and a criterion, with all its runs that did not fail.

    Attributes:
        problem: Its name.
        criterion: "J_k" or "J_d".
        base: Base parameters of the problem, b.
        runs: In order of appearance.
        failed: How many failed.
    """

    problem: str
    criterion: str
    base: int
    runs: tuple[Run, ...]
    failed: int

    def optimisers(self, seconds: float) -> list[str]:
        """Those that were run to a budget, in order of appearance."""
        return list(dict.fromkeys(run.optimiser for run in self.runs if run.seconds >= seconds))

    def costs(self, optimiser: str, seconds: float) -> dict[int, float]:
        """Best cost by a budget, by seed, of the runs that went on so long."""
        return {
            run.seed: cost_at(run.history, "cpu_s", seconds)
            for run in self.runs
            if run.optimiser == optimiser and run.seconds >= seconds
        }

    def decades(self, factor: float) -> float:
        """What a factor in J_k, or in the information about every parameter, is in the cost."""
        return (1 if self.criterion == "J_k" else self.base) * float(np.log10(factor))

    def factor(self, cost: float) -> float:
        """The inverse of `decades`."""
        return float(10.0 ** (cost / (1 if self.criterion == "J_k" else self.base)))

    def value(self, cost: float) -> float:
        """J_k or J_d of a cost."""
        return 10.0**cost if self.criterion == "J_k" else -cost


def cells_of(rows: Sequence[Mapping[str, str]]) -> list[Cell]:
    """The cells of the lines of runs.csv, in order of appearance."""
    found: dict[tuple[str, str], list[Mapping[str, str]]] = {}
    for row in rows:
        found.setdefault((row["problem"], row["criterion"]), []).append(row)
    return [_cell(*key, lines) for key, lines in sorted(found.items(), reverse=True)]


def _cell(problem: str, criterion: str, rows: Sequence[Mapping[str, str]]) -> Cell:
    good = [row for row in rows if not row["status"].startswith(FAILED)]
    runs = tuple(
        Run(
            row["optimiser"],
            int(row["seed"]),
            float(row["cpu_budget_s"]),
            read_history(row["history"]),
            row["status"],
            float(row["certified_violation"]),
        )
        for row in good
    )
    base = int(good[0]["base"]) if good else 1
    return Cell(problem, criterion, base, runs, len(rows) - len(good))


@dataclass(frozen=True)
class Comparison:
    """How much better one optimiser is than another at a budget.

    Attributes:
        pairs: Seeds that both were run with.
        won: Of these, by the first.
        gain: Geometric mean of the ratios of J_k, the other's to the first's, or of the
            information about every parameter, the first's to the other's.
        low: Lower end of its interval.
        high: Upper end.
    """

    pairs: int
    won: int
    gain: float
    low: float
    high: float

    @property
    def verdict(self) -> str:
        """The outcome; every one of the four can come out."""
        return judge(self.low, self.high)


def compare(cell: Cell, first: str, other: str, seconds: float) -> Comparison:
    """Hold one optimiser against another by the paired t interval of the difference of costs.

    All pairs of optimisers of a budget are compared at once (Bonferroni), as the best of them is
    only known from the same runs.
    """
    own, rival = (cell.costs(name, seconds) for name in (first, other))
    seeds = sorted(own.keys() & rival.keys())
    gains = np.array([rival[seed] - own[seed] for seed in seeds])
    low, high, mean = -np.inf, np.inf, float("nan")
    if len(gains) and np.isfinite(gains).all():
        mean = float(gains.mean())
    if len(gains) > 1 and np.isfinite(mean):
        count = len(cell.optimisers(seconds))
        level = 1 - (1 - LEVEL) / (count * (count - 1) / 2)
        half = stats.t.ppf(0.5 + level / 2, len(gains) - 1) * stats.sem(gains)
        low, high = mean - half, mean + half
    bounds = (cell.factor(low), cell.factor(high))
    return Comparison(len(gains), int((gains > 0).sum()), cell.factor(mean), *bounds)


def judge(low: float, high: float) -> str:
    """The verdict on an interval of the gain of the first over the other."""
    if low >= 1 / (1 + MATTERS) and high <= 1 + MATTERS:
        return "as good"
    if low > 1.0:
        return "ahead"
    if high < 1.0:
        return "behind"
    return "not told apart"


def ranked(cell: Cell, seconds: float) -> list[str]:
    """The optimisers of a budget by mean cost, the best first."""
    means = {
        name: float(np.mean(list(cell.costs(name, seconds).values())))
        for name in cell.optimisers(seconds)
    }
    return sorted(means, key=lambda name: means[name])
