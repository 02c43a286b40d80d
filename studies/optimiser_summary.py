"""What the runs of `studies.compare_optimisers` say: one table a question, and a figure."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from oed.design.optimisers.target_hits import expected_cost, first_hit, hit_curve
from oed.report.comparison_plots import HitPanel, plot_target_hits
from oed.report.json_file import write_atomically
from oed.report.style import save_figure
from oed.report.table import Row, markdown_table
from studies.optimiser_comparison import LEVEL, MATTERS, Cell, cells_of, compare, ranked
from studies.optimiser_targets import best_known, other_classes, target_row

DEFAULT = "interior-point"  # of the command
WITHOUT_GRADIENT = ("genetic", "cma-es", "random")
NAMES = {"paper": "the paper's arm of two joints", "panda": "a Panda of seven joints"}
LOSSES = (0.05, 0.01)
# Of the figure: from 1 % to three times worse than the best known.
CURVE_LOSSES = np.geomspace(0.01, 3.0, 25)
CURVE_POINTS = 200
SOONEST = 0.02  # [s] of CPU time where the figure begins: a few evaluations
HOPS = re.compile(r"\b(\d+) hops?\b")
SAID = """\
- One optimiser is *ahead* of another at a budget if the interval of its gain, seed by seed, lies wholly above 1;
  *as good* if it lies within {matters:.0%} of 1; *not told apart* otherwise. The gain is the ratio of J_k, or of the
  information about every parameter, 10^(difference of J_d / base parameters), in the geometric mean. Intervals are
  those of Student's t, {level:.0%} for all pairs of a budget together (Bonferroni). "The best" below has the best mean; that
  ranking is refuted for each rival that is not told apart from it.
- That {default}, the default of the command, is beaten by none at any budget: refuted where another is ahead of it.
- That gradients pay: refuted where the best optimiser without them is ahead of the best with them, not shown where
  these two are not told apart.
"""
INTRODUCTION = """\
# Optimisers compared

Fourier series of five harmonics in 10 s on the paper's arm of two joints (J_k and J_d) and on a Panda of seven (J_d alone), 80
instants, R_v = I, J_d to base 10, limits of position, velocity and acceleration proven for all t (worst violation of
any final motion: {violation:.1e} of a limit). The value at a budget is that of the best motion within the limits by that CPU
time. Every point at which an optimiser asked for a gradient counts, also before its first local solution ends: it is
brought within the limits and evaluated exactly after the run, off the clock. Means are over seeds.

Runs of each method, one a seed: {seeds}. A run of a longer budget
serves the shorter ones. How many there are was set by the time that the machine had; the last were added when results of the
first had been seen. An entry that was not run is empty; where there is one run each there is no test.{failed} "(0 hops)"
stands where no run of just that budget came to a hop from one local solution to a neighbour of it: the method is then worth
its starts alone.

## Said before the study was run

{said}
"""


def write_summary(rows: Sequence[Mapping[str, str]], budgets: Sequence[float], out: Path) -> None:
    """Leave summary.md and the figure of target hits.

    Args:
        rows: Lines of runs.csv.
        budgets: CPU times at which runs are read [s], the shortest first.
        out: Folder, made where there is none.
    """
    cells = cells_of(rows)
    known = {(cell.problem, cell.criterion): best_known(cell) for cell in cells}
    targets = [target_row(cell, *known[cell.problem, cell.criterion]) for cell in cells]
    text = _introduction(cells, budgets)
    for problem in dict.fromkeys(cell.problem for cell in cells):
        own = [cell for cell in cells if cell.problem == problem]
        text += f"""
## Which optimiser for {NAMES[problem]}?

{markdown_table([row for cell in own for row in best_rows(cell, budgets)])}"""
    text += f"""
## What was said, and what came out

{markdown_table([row for cell in cells for row in said_rows(cell, budgets)])}
## What did each reach?

Median of the seeds, and from the worst to the best of them.

{markdown_table([row for cell in cells for row in reached_rows(cell, budgets)])}
## By how much is the best ahead of each?

{markdown_table([row for cell in cells for row in pair_rows(cell, budgets)])}
## How long until a motion is near the best known?

Runs within 5 % and 1 % of the best known value (in J_k, or in the information about every parameter), and the CPU time
that restarts of such runs are expected to take until one succeeds: all time spent up to the limit, over the successes up to
the same limit. A dash: none succeeded. The figure `target_hits.png` counts, by CPU time, the pairs of a run and one of {len(CURVE_LOSSES)}
targets from 1 % to three times worse than the best known that had been hit, up to the last budget with two runs.

{markdown_table([row for cell in cells for row in hit_rows(cell, known[cell.problem, cell.criterion][0], budgets)])}
## What is the best known?

{markdown_table(targets)}{other_classes()}"""
    write_atomically(out / "summary.md", text)
    panels = [hit_panel(cell, known[cell.problem, cell.criterion][0]) for cell in cells]
    save_figure(plot_target_hits(panels), out / "target_hits")


def _introduction(cells: Sequence[Cell], budgets: Sequence[float]) -> str:
    counts = [
        f"{seconds:g} s: {', '.join(sorted({str(len(cell.costs(name, seconds))) for cell in cells for name in cell.optimisers(seconds)}, key=int))}"
        f" ({_all_or_some(cells, seconds)})"
        for seconds in budgets
    ]
    failed = sum(cell.failed for cell in cells)
    return INTRODUCTION.format(
        violation=max(run.violation for cell in cells for run in cell.runs),
        seeds="; ".join(counts),
        failed=f" {failed} runs failed." if failed else "",
        said=SAID.format(matters=MATTERS, level=LEVEL, default=DEFAULT).rstrip(),
    )


def _all_or_some(cells: Sequence[Cell], seconds: float) -> str:
    """Which cells and optimisers were run to a budget."""
    run = [cell for cell in cells if cell.optimisers(seconds)]
    names = list(dict.fromkeys(name for cell in run for name in cell.optimisers(seconds)))
    every = {run.optimiser for cell in cells for run in cell.runs}
    where = "" if len(run) == len(cells) else ", ".join(f"{c.problem} {c.criterion}" for c in run)
    who = "all optimisers" if set(names) == every else ", ".join(names)
    return f"{who}; {where} alone" if where else who


def best_rows(cell: Cell, budgets: Sequence[float]) -> list[Row]:
    """A line a budget: the best mean, and which are not told apart from it."""
    rows: list[Row] = []
    for seconds in budgets:
        first, *others = ranked(cell, seconds) or [""]
        if not first:
            rows.append({"criterion": cell.criterion, "CPU s": f"{seconds:g}", "best": "not run"})
            continue
        verdicts = {name: compare(cell, first, name, seconds).verdict for name in others}
        costs = list(cell.costs(first, seconds).values())
        of = {
            verdict: "no test"
            if len(costs) < 2
            else ", ".join(name for name in others if verdicts[name] == verdict) or "none"
            for verdict in ("ahead", "as good", "not told apart")
        }
        rows.append(
            {
                "criterion": cell.criterion,
                "CPU s": f"{seconds:g}",
                "best": first + _hops(cell, first, seconds),
                "mean value": f"{cell.value(float(np.mean(costs))):.5g}",
                "runs": len(costs),
                "as good": of["as good"],
                "not told apart from": of["not told apart"],
                "ahead of": of["ahead"],
            }
        )
    return rows


def _hops(cell: Cell, name: str, seconds: float) -> str:
    """A note where every run of just this budget says that it made no hop."""
    said = [
        HOPS.search(run.status)
        for run in cell.runs
        if run.optimiser == name and run.seconds == seconds
    ]
    none = bool(said) and all(match is not None and match[1] == "0" for match in said)
    return " (0 hops)" if none else ""


def said_rows(cell: Cell, budgets: Sequence[float]) -> list[Row]:
    """The verdict on each claim at each budget."""
    rows: list[Row] = []
    for seconds in (each for each in budgets if cell.optimisers(each)):
        order = ranked(cell, seconds)
        without = [name for name in order if name in WITHOUT_GRADIENT]
        within = [name for name in order if name not in WITHOUT_GRADIENT]
        line = {"problem": cell.problem, "criterion": cell.criterion, "CPU s": f"{seconds:g}"}
        line |= {"beaten by none": "not run", "gradients pay": "not run"}
        if DEFAULT in order:
            ahead = [
                name
                for name in order
                if name != DEFAULT and compare(cell, DEFAULT, name, seconds).verdict == "behind"
            ]
            line["beaten by none"] = f"refuted: {', '.join(ahead)}" if ahead else "not refuted"
            if not ahead and len(cell.costs(DEFAULT, seconds)) < 2:
                line["beaten by none"] = "one run a method: no test"
        if within and without:
            outcome = compare(cell, within[0], without[0], seconds).verdict
            line["gradients pay"] = {"ahead": "confirmed", "behind": "refuted"}.get(
                outcome, f"not shown: {within[0]} {outcome} {without[0]}"
            )
        rows.append(line)
    return rows


def reached_rows(cell: Cell, budgets: Sequence[float]) -> list[Row]:
    """A line an optimiser: median, worst and best at each budget."""
    rows: list[Row] = []
    for name in cell.optimisers(budgets[0]):
        line: dict[str, str] = {
            "problem": cell.problem,
            "criterion": cell.criterion,
            "optimiser": name,
        }
        for seconds in budgets:
            costs = np.array(list(cell.costs(name, seconds).values()))
            shown = ""
            if len(costs):
                middle, worst, best = (
                    f"{cell.value(float(cost)):.5g}"
                    for cost in (np.median(costs), costs.max(), costs.min())
                )
                spread = f" [{worst}, {best}]" if len(costs) > 1 else ""
                shown = f"{middle}{spread}{_hops(cell, name, seconds)}"
            line[f"{seconds:g} s"] = shown
        rows.append(line)
    return rows


def pair_rows(cell: Cell, budgets: Sequence[float]) -> list[Row]:
    """A line a budget and rival of its best: gain and interval."""
    rows: list[Row] = []
    for seconds in budgets:
        first, *others = ranked(cell, seconds) or [""]
        for name in others:
            found = compare(cell, first, name, seconds)
            is_tested = found.pairs > 1
            rows.append(
                {
                    "problem": cell.problem,
                    "criterion": cell.criterion,
                    "CPU s": f"{seconds:g}",
                    "best": first,
                    "against": name,
                    "won": f"{found.won} of {found.pairs}",
                    "gain": f"{found.gain:.3f}",
                    "interval": f"[{found.low:.3f}, {found.high:.3f}]" if is_tested else "",
                    "verdict": found.verdict if is_tested else "one run each: no test",
                }
            )
    return rows


def hit_rows(cell: Cell, best: float, budgets: Sequence[float]) -> list[Row]:
    """A line a limit and optimiser: successes and expected time, both to that limit."""
    rows: list[Row] = []
    for limit in budgets:
        for name in cell.optimisers(limit):
            runs = [run for run in cell.runs if run.optimiser == name and run.seconds >= limit]
            line: dict[str, str | float] = {
                "problem": cell.problem,
                "criterion": cell.criterion,
                "limit [CPU s]": f"{limit:g}",
                "optimiser": name,
            }
            for loss in LOSSES:
                target = best + cell.decades(1 + loss)
                hits = np.array([first_hit(run.history, "cpu_s", target) for run in runs])
                hits[hits > limit] = np.inf
                expected = expected_cost(hits, np.full(len(hits), limit))
                line[f"within {loss:.0%}"] = f"{np.isfinite(hits).sum()} of {len(hits)}"
                line[f"expected to {loss:.0%} [s]"] = (
                    expected if np.isfinite(expected) else float("nan")
                )
            rows.append(line)
    return rows


def hit_panel(cell: Cell, best: float) -> HitPanel:
    """Hits of all targets against CPU time, to the last budget that an optimiser has two runs of."""
    targets = [best + cell.decades(1 + float(loss)) for loss in CURVE_LOSSES]
    limits = {
        name: sorted(run.seconds for run in cell.runs if run.optimiser == name)[-2:][0]
        for name in cell.optimisers(0.0)
    }
    amounts = np.geomspace(SOONEST, max(limits.values()), CURVE_POINTS)
    curves = {}
    for name, limit in limits.items():
        runs = [run for run in cell.runs if run.optimiser == name and run.seconds >= limit]
        hits = [first_hit(run.history, "cpu_s", target) for run in runs for target in targets]
        curves[name] = np.where(amounts <= limit, hit_curve(np.array(hits), amounts), np.nan)
    return HitPanel(f"{cell.problem}, {cell.criterion}", amounts, curves, 1.0, "CPU time [s]")
