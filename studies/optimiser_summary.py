"""What the runs of `studies.compare_optimisers` say: table, figure, and who wins where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy import ndarray

from oed.design.optimisers.result import HistoryPoint
from oed.design.optimisers.target_hits import (
    Resource,
    cost_at,
    expected_cost,
    first_hit,
    hit_curve,
    median_interval,
    read_history,
)
from oed.report.comparison_plots import HitPanel, plot_target_hits
from oed.report.json_file import write_atomically
from oed.report.style import save_figure
from oed.report.table import markdown_table, write_csv

Row = Mapping[str, str]
Cell = tuple[str, str, str]  # problem, class, criterion
BOOTSTRAP_SEED = 0
RESOURCES: tuple[Resource, Resource] = ("evaluations", "cpu_s")
UNITS = ("evaluations", "CPU seconds")
LABELS = ("evaluations", "CPU time [s]")
LOSSES = (0.05, 0.01)
# Of the figure: from 1 % to three times worse than the best.
CURVE_LOSSES = np.geomspace(0.01, 3.0, 25)
CURVE_POINTS = 200
PAPER_J_K = 13.34  # Calafiore 2001, section 5; its horizon is not stated
INTRODUCTION = """\
A cell is a problem, a class and a criterion. Every run goes on until it has used both budgets, or
{longest:g} times the CPU budget, which can leave it short of evaluations (see median_evaluations);
values are read at the budget. Its *target* is the best value that
any run of the cell found: within 5 % means J_k at most 1.05 times it, or a D-efficiency
(det Lambda / det best)^(1/b) of at least 1 / 1.05. The figure counts, after each amount, the pairs of
a run and one of {targets} targets, from 1 % to three times worse than the best, that had been hit. Medians are over seeds, in brackets their 95 %
bootstrap interval. An evaluation with its gradient counts as one evaluation; what it costs shows
in the CPU time. `hit` is the share of seeds within so many per cent at the CPU budget; "expected"
is all CPU time spent by all seeds per success in the whole of their runs, which go on after it. Criteria are of
80 instants, R_v = I, J_d to base 10.
"""


@dataclass(frozen=True)
class Runs:
    """The runs of one optimiser in one cell that did not fail."""

    histories: tuple[tuple[HistoryPoint, ...], ...]
    spent: ndarray
    evaluations: ndarray
    violations: ndarray
    failed: int

    @property
    def best(self) -> float:
        """Lowest cost."""
        return min((h[-1].cost for h in self.histories if h), default=float("inf"))


def write_summary(rows: Sequence[Row], sizes: Mapping[str, int], longest: float, out: Path) -> None:
    """Leave summary.csv, summary.md and the figure of target hits.

    Args:
        rows: Lines of runs.csv.
        sizes: Number of base parameters of each problem.
        longest: Multiple of the CPU budget at which runs are cut.
        out: Folder.
    """
    cells = group(rows)
    budgets = (float(rows[0]["evaluations_budget"]), float(rows[0]["cpu_budget_s"]))
    table = [line for cell, runs in cells.items() for line in lines(cell, runs, sizes, budgets)]
    write_csv(out / "summary.csv", table)
    text = [
        "# Optimisers compared\n",
        INTRODUCTION.format(longest=longest, targets=len(CURVE_LOSSES)),
        f"Budgets: {budgets[0]:g} evaluations, {budgets[1]:g} CPU seconds.\n",
        "## Who wins where\n",
        *statements(cells, budgets),
        *against_the_paper(cells),
        "\n## All cells\n",
        markdown_table([_readable(line) for line in table]),
    ]
    write_atomically(out / "summary.md", "\n".join(text))
    save_figure(plot_target_hits(hit_panels(cells, sizes, budgets, longest)), out / "target_hits")


def group(rows: Sequence[Row]) -> dict[Cell, dict[str, Runs]]:
    """Runs by cell and optimiser, in order of appearance."""
    found: dict[Cell, dict[str, list[Row]]] = {}
    for row in rows:
        cell = (row["problem"], row["class"], row["criterion"])
        found.setdefault(cell, {}).setdefault(row["optimiser"], []).append(row)
    return {cell: {o: _runs(r) for o, r in by.items()} for cell, by in found.items()}


def _runs(rows: Sequence[Row]) -> Runs:
    good = [row for row in rows if not row["status"].startswith("failed")]
    return Runs(
        tuple(read_history(row["history"]) for row in good),
        np.array([float(row["cpu_s"]) for row in good]),
        np.array([float(row["evaluations"]) for row in good]),
        np.array([float(row["certified_violation"]) for row in good]),
        len(rows) - len(good),
    )


def value_of(cost: float, criterion: str) -> float:
    """J_k or J_d of a cost."""
    return 10.0**cost if criterion == "J_k" else -cost


def target_cost(best: float, loss: float, criterion: str, size: int) -> float:
    """The cost at which a design is within `loss` of the best one."""
    return best + (1 if criterion == "J_k" else size) * float(np.log10(1 + loss))


def lines(
    cell: Cell,
    by_optimiser: Mapping[str, Runs],
    sizes: Mapping[str, int],
    budgets: tuple[float, float],
) -> list[dict[str, str | int | float]]:
    """A line of the table for every optimiser of a cell."""
    criterion = cell[2]
    best = min(runs.best for runs in by_optimiser.values())
    result = []
    for name, runs in by_optimiser.items():
        line: dict[str, str | int | float] = dict(
            zip(("problem", "class", "criterion"), cell, strict=True)
        )
        line |= {"optimiser": name, "seeds": len(runs.histories), "failed": runs.failed}
        for resource, budget in zip(RESOURCES, budgets, strict=True):
            low, middle, high = _at_budget(runs, resource, budget)
            line |= {
                f"median_at_{resource}": value_of(middle, criterion),
                f"low_at_{resource}": min(value_of(x, criterion) for x in (low, high)),
                f"high_at_{resource}": max(value_of(x, criterion) for x in (low, high)),
            }
        line["best"] = value_of(runs.best, criterion)
        for loss in LOSSES:
            target = target_cost(best, loss, criterion, sizes[cell[0]])
            hits = np.array([first_hit(h, "cpu_s", target) for h in runs.histories])
            line[f"hit_{loss:.0%}".replace("%", "")] = float((hits <= budgets[1]).mean())
            line[f"expected_cpu_s_{loss:.0%}".replace("%", "")] = expected_cost(hits, runs.spent)
        line["median_evaluations"] = float(np.median(runs.evaluations))
        line["worst_violation"] = float(runs.violations.max(initial=-np.inf))
        result.append(line)
    return result


def _at_budget(runs: Runs, resource: Resource, budget: float) -> tuple[float, float, float]:
    """Lower, median and upper cost at a budget."""
    costs = np.array([cost_at(h, resource, budget) for h in runs.histories])
    middle, low, high = median_interval(costs, np.random.default_rng(BOOTSTRAP_SEED))
    return low, middle, high


def _readable(line: Mapping[str, str | int | float]) -> dict[str, str | int | float]:
    """A line with each median and its interval in one cell."""
    kept = {k: v for k, v in line.items() if not k.startswith(("median_at", "low_at", "high_at"))}
    shown: dict[str, str | int | float] = {
        k: kept.pop(k) for k in ("problem", "class", "criterion", "optimiser", "seeds")
    }
    for resource, title in (("evaluations", "at evaluations"), ("cpu_s", "at CPU time")):
        middle, low, high = (line[f"{k}_at_{resource}"] for k in ("median", "low", "high"))
        shown[title] = f"{middle:.4g} [{low:.4g}, {high:.4g}]"
    return shown | kept


def statements(cells: Mapping[Cell, Mapping[str, Runs]], budgets: tuple[float, float]) -> list[str]:
    """One sentence a cell and budget: the best median, and which others are not told apart."""
    sentences = []
    for cell, by_optimiser in cells.items():
        for resource, budget, unit in zip(RESOURCES, budgets, UNITS, strict=True):
            sentences.append(_sentence(cell, by_optimiser, resource, budget, unit))
    return sentences


def against_the_paper(cells: Mapping[Cell, Mapping[str, Runs]]) -> list[str]:
    """How the paper's own algorithm, on its own class and bounds, compares with its value."""
    genetic = cells.get(("scara", "conservative", "J_k"), {}).get("genetic")
    if genetic is None or not genetic.histories:
        return []
    values = np.array([10.0 ** h[-1].cost for h in genetic.histories if h])
    below = int((values < PAPER_J_K).sum())
    sentence = (
        "\nThe paper's genetic algorithm on its class, bounds and 4-bit genes, at the end of its runs "
        f"(median {np.median(genetic.evaluations):.0f} evaluations): best J_k {values.min():.4g}, median "
        f"{np.median(values):.4g}; {below} of {len(values)} seeds beat the paper's {PAPER_J_K}."
    )
    return [sentence]


def _sentence(
    cell: Cell, by_optimiser: Mapping[str, Runs], resource: Resource, budget: float, unit: str
) -> str:
    intervals = {name: _at_budget(runs, resource, budget) for name, runs in by_optimiser.items()}
    ranked = sorted(intervals, key=lambda name: intervals[name][1])
    first = ranked[0]
    tied = [name for name in ranked[1:] if intervals[name][0] <= intervals[first][2]]
    value = value_of(intervals[first][1], cell[2])
    text = f"- {cell[0]}, {cell[1]}, {cell[2]}, {budget:g} {unit}: **{first}**, median {value:.4g}"
    if tied:
        text += f"; not told apart from {', '.join(tied)} (intervals overlap)"
    others = [name for name in ranked[1:] if name not in tied]
    if others:
        rest = ", ".join(f"{n} {value_of(intervals[n][1], cell[2]):.4g}" for n in others)
        text += f"; ahead of {rest}"
    return text + "."


def hit_panels(
    cells: Mapping[Cell, Mapping[str, Runs]],
    sizes: Mapping[str, int],
    budgets: tuple[float, float],
    longest: float,
) -> list[HitPanel]:
    """Two panels a cell: hits of all targets against evaluations and against CPU time."""
    panels = []
    for cell, by_optimiser in cells.items():
        best = min(runs.best for runs in by_optimiser.values())
        targets = [target_cost(best, loss, cell[2], sizes[cell[0]]) for loss in CURVE_LOSSES]
        for resource, budget, label in zip(RESOURCES, budgets, LABELS, strict=True):
            amounts = np.geomspace(budget / 50, budget * longest, CURVE_POINTS)
            curves = {
                name: hit_curve(
                    np.array(
                        [
                            first_hit(history, resource, target)
                            for history in runs.histories
                            for target in targets
                        ]
                    ),
                    amounts,
                )
                for name, runs in by_optimiser.items()
            }
            panels.append(HitPanel(", ".join(cell), amounts, curves, budget, label))
    return panels
