"""The page of `studies.effect_intervals`: coverage and scaled errors, by effect and in all."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import beta

from oed.report.table import markdown_table
from studies.bench.score import QUANTILE

ENOUGH = 20  # intervals of an effect: of fewer, one miss moves the share by more than 5 %
PROMISE = (0.92, 0.98)  # coverage of 95 % intervals
LEVEL = 0.95  # of the intervals of the coverage itself


@dataclass(frozen=True)
class Interval:
    """An estimated parameter beside its true value, both in the same SI unit.

    Attributes:
        name: Of the parameter.
        truth: As injected.
        estimate: As the diagnosis has it.
        std: Its standard deviation as the diagnosis has it.
    """

    name: str
    truth: float
    estimate: float
    std: float

    @property
    def z(self) -> float:
        """Error in standard deviations; infinite for an error without one."""
        error = self.estimate - self.truth
        return error / self.std if self.std > 0 else float(np.copysign(np.inf, error))

    @property
    def covered(self) -> bool:
        """Whether the 95 % interval holds the truth."""
        return abs(self.estimate - self.truth) <= QUANTILE * self.std


def packed(intervals: Iterable[Interval]) -> str:
    """As one cell of a table: name truth estimate std z, separated by bars."""
    return " | ".join(
        f"{i.name} {i.truth:.6g} {i.estimate:.6g} {i.std:.3g} {i.z:.3g}" for i in intervals
    )


def unpacked(cell: str) -> list[Interval]:
    """What `packed` wrote."""
    parts = [part.split() for part in cell.split(" | ") if part]
    return [Interval(name, float(a), float(b), float(c)) for name, a, b, c, _ in parts]


def clopper_pearson(hits: int, trials: int) -> tuple[float, float]:
    """Exact interval of a share (Clopper and Pearson 1934, Biometrika 26(4))."""
    tail = (1 - LEVEL) / 2
    lower = float(beta.ppf(tail, hits, trials - hits + 1)) if hits else 0.0
    upper = float(beta.ppf(1 - tail, hits + 1, trials - hits)) if hits < trials else 1.0
    return lower, upper


def page(rows: Sequence[Mapping[str, str]]) -> str:
    """The summary."""
    by_effect: dict[str, list[Interval]] = defaultdict(list)
    by_parameter: dict[tuple[str, str], list[Interval]] = defaultdict(list)
    by_setting: dict[str, list[Interval]] = defaultdict(list)
    for row in rows:
        repeated = "repeated" if row["repeated"] == "yes" else "not repeated"
        for interval in unpacked(row["intervals"]):
            by_effect[row["effect"]].append(interval)
            by_parameter[row["effect"], interval.name].append(interval)
            by_setting[f"{row['noise']}, {repeated}"].append(interval)
    every = [i for group in by_effect.values() for i in group]
    if not every:
        return "# Intervals of the effects' parameters\n\nNo intervals.\n"
    effects = [
        {"effect": name, "data sets": _named(rows, name), **_line(group)}
        for name, group in sorted(by_effect.items())
    ]
    total = {"effect": "all", "data sets": _named(rows, None), **_line(every)}
    parameters = [
        {"effect": effect, "parameter": name, **_line(group)}
        for (effect, name), group in sorted(by_parameter.items())
    ]
    settings = [{"noise": name, **_line(group)} for name, group in sorted(by_setting.items())]
    return "\n".join(
        [
            "# Intervals of the effects' parameters\n",
            _statements(rows, every, by_effect),
            "## By effect\n",
            markdown_table([*effects, total], digits=3),
            "## By parameter\n",
            markdown_table(parameters, digits=3),
            "## By noise\n",
            markdown_table(settings, digits=3),
            _without(rows),
        ]
    )


def _line(group: Sequence[Interval]) -> dict[str, str | int | float]:
    """Coverage and scaled errors of some intervals."""
    hits = sum(i.covered for i in group)
    lower, upper = clopper_pearson(hits, len(group))
    z = np.array([i.z for i in group])
    # Half the distance between the 16th and 84th percentile: 1 for errors as stated.
    low, high = np.percentile(z, [15.87, 84.13])
    return {
        "intervals": len(group),
        "covered": hits,
        "share": hits / len(group),
        "95 % of the share": f"{lower:.2f} to {upper:.2f}",
        "median z": float(np.median(z)),
        "spread of z": float((high - low) / 2),
        "largest abs z": float(np.abs(z).max()),
    }


def _named(rows: Sequence[Mapping[str, str]], effect: str | None) -> str:
    own = [row for row in rows if effect in (None, row["effect"])]
    return f"{sum(bool(row['intervals']) for row in own)} of {len(own)}"


def _statements(
    rows: Sequence[Mapping[str, str]],
    every: Sequence[Interval],
    by_effect: Mapping[str, Sequence[Interval]],
) -> str:
    hits = sum(i.covered for i in every)
    share, (lower, upper) = hits / len(every), clopper_pearson(hits, len(every))
    least, most = PROMISE
    below = [
        name
        for name, group in sorted(by_effect.items())
        if clopper_pearson(sum(i.covered for i in group), len(group))[1] < least
    ]
    few = [name for name, group in by_effect.items() if len(group) < ENOUGH]
    promise = (
        f"not kept for {', '.join(below)}"
        if below
        else f"not contradicted, and not shown for {len(few)} of {len(by_effect)} effects, which have "
        f"fewer than {ENOUGH} intervals"
        if few
        else "not contradicted for any"
    )
    return (
        "Simulated arms of the bench, one hidden effect each; the diagnosis is told its name but "
        "not its joint, its shape or its size. z is the error in reported standard deviations; "
        "its spread is half the distance of its 16th and 84th percentiles, 1 if these are right. "
        "`data sets` says in how many the effect was named where it was; intervals of one data "
        "set are not independent, which the intervals of the shares do not count.\n\n"
        f"- **{hits} of {len(every)} intervals ({100 * share:.1f} %) hold the injected value** "
        f"({100 * lower:.1f} to {100 * upper:.1f} %).\n"
        f"- Promised are {100 * least:g} to {100 * most:g} % for every effect: {promise}.\n"
        f"- {_named(rows, None)} data sets gave intervals.\n"
    )


def _without(rows: Sequence[Mapping[str, str]]) -> str:
    silent = [
        {
            "effect": row["effect"] or row["hidden"],
            "arm": row["robot"],
            "noise": row["noise"],
            "repeated": row["repeated"],
            "seed": row["seed"],
            "outcome": row["status"],
        }
        for row in rows
        if not row["intervals"]
    ]
    return f"## Without intervals\n\n{markdown_table(silent)}" if silent else ""
