"""A line of the bench, whether what it says is right, and how often that is so."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from scipy import stats

from studies.bench.score import NOTHING

BenchRow = Mapping[str, str]
LEVEL = 0.95


@dataclass(frozen=True)
class Rate:
    """A share with its interval (Clopper and Pearson 1934).

    Attributes:
        hits: Cases that count.
        cases: All.
    """

    hits: int
    cases: int

    @property
    def interval(self) -> tuple[float, float]:
        """Of 95 %."""
        tail = (1 - LEVEL) / 2
        k, n = self.hits, self.cases
        low = float(stats.beta.ppf(tail, k, n - k + 1)) if k > 0 else 0.0
        high = float(stats.beta.ppf(1 - tail, k + 1, n - k)) if k < n else 1.0
        return low, high

    def __str__(self) -> str:
        if not self.cases:
            return "–"
        low, high = self.interval
        return f"{self.hits} of {self.cases} ({100 * low:.0f}–{100 * high:.0f} %)"


def done(rows: Sequence[BenchRow]) -> list[BenchRow]:
    """The cases that ended with a diagnosis."""
    return [row for row in rows if row["status"] == "done"]


def rate(rows: Sequence[BenchRow], holds: Callable[[BenchRow], bool]) -> Rate:
    """How often something holds."""
    return Rate(sum(map(holds, rows)), len(rows))


def is_exact(row: BenchRow) -> bool:
    """Whether all that is hidden is named, or traced, and nothing else is named."""
    return is_found(row) and row["extra"] == "0"


def is_found(row: BenchRow) -> bool:
    """Whether all that is hidden is named at its joint, or traced to its coordinates."""
    return row["missed"] == "0" and row["nearly"] == "0" and row["coordinates_right"] != "no"


def is_class_right(row: BenchRow) -> bool:
    """Whether all that is hidden is named, its equal or as one of several rivals."""
    return row["missed"] == "0" and row["coordinates_right"] != "no"


def is_alarm(row: BenchRow) -> bool:
    """Whether anything is named."""
    return bool(row["claims"])


def is_quiet(row: BenchRow) -> bool:
    """Whether nothing is said to be missing."""
    return row["verdict"] == NOTHING and not is_alarm(row)
