"""What the designs of `studies.free_frequencies` say: tables and figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from oed.design.optimisers.target_hits import expected_cost, first_hit, read_history
from oed.report.comparison_plots import DependencePanel, plot_dependence
from oed.report.json_file import write_atomically
from oed.report.style import save_figure
from oed.report.table import markdown_table

Row = Mapping[str, str]
Line = dict[str, str | int | float]
CRITERIA = ("J_k", "J_d")
# Best values of an earlier, quick study of the reference problem, to be reached or beaten.
EARLIER = {"J_k": 6.905, "J_d": 20.883}
LOSSES = (0.05, 0.01)
NAMES = {"amplitude_bound": "bound on |a| [rad]", "horizon": "horizon T [s]"}
INTRODUCTION = """\
# Free frequencies under exact limits

The paper's arm and limits, sums of three sines a joint with amplitudes and frequencies both free, limits
proven to be kept at all times; 80 instants, 160 rows, R_v = I, J_k = cond Lambda, J_d to base 10.
Designs by `oed.design.optimisers.hopping`; every line is a run of its own seed with the CPU time stated.

## The reference: |a| <= {amplitude:g} rad, T = {horizon:g} s

An earlier study's best: J_k {J_k}, J_d {J_d}. Best of the runs at this bound: **J_k {best_J_k:.3f}**, **J_d {best_J_d:.3f}**.
"Within 5 %" of a target means J_k at most 1.05 times it, or a determinant of at least 1 / 1.05 times its
determinant, which is 0.02 in J_d. "expected CPU" is all time spent by all seeds per success; "per local
solution" is the share of local solutions that ended in a success, counted until the first one of each run.

"""


def write_summary(rows: Sequence[Row], reference: tuple[float, float], out: Path) -> None:
    """Leave summary.md and the figure of the dependence on the bounds.

    Args:
        rows: Lines of runs.csv.
        reference: Amplitude bound [rad] and horizon [s] of the reference.
        out: Folder.
    """
    good = [row for row in rows if not row["status"].startswith("failed")]
    here = [row for row in good if _place(row) == reference]
    best = {criterion: _best(here, criterion) for criterion in CRITERIA}
    text = INTRODUCTION.format(
        amplitude=reference[0],
        horizon=reference[1],
        **EARLIER,
        **{f"best_{criterion}": value for criterion, value in best.items()},
    )
    text += markdown_table(hit_lines(here, best))
    for name, heading in (
        ("amplitude_bound", "the bound of amplitudes"),
        ("horizon", "the horizon"),
    ):
        text += f"\n## Dependence on {heading}\n\n"
        if name == "amplitude_bound":
            text += "A motion within a narrower bound is one within a wider: `at_most` is the best of both.\n\n"
        text += markdown_table(dependence_lines(good, reference, name))
    text += "\n## All runs\n\n" + markdown_table([_run_line(row) for row in rows])
    write_atomically(out / "summary.md", text)
    save_figure(plot_dependence(panels(good, reference)), out / "dependence")


def hit_lines(rows: Sequence[Row], best: Mapping[str, float]) -> list[Line]:
    """What it takes to come near the earlier study's values and the best ones."""
    result: list[Line] = []
    for criterion in CRITERIA:
        runs = [row for row in rows if row["criterion"] == criterion]
        spent = np.array([float(row["cpu_s"]) for row in runs])
        solutions = np.array([_local_solutions(row["status"]) for row in runs])
        for source, target in (
            ("earlier", EARLIER[criterion]),
            ("best at this bound", best[criterion]),
        ):
            for loss in LOSSES:
                hits = np.array(
                    [
                        first_hit(
                            read_history(row["history"]), "cpu_s", _cost(target, loss, criterion)
                        )
                        for row in runs
                    ]
                )
                is_hit = np.isfinite(hits)
                tried = (solutions * np.minimum(hits, spent) / spent).sum()
                result.append(
                    {
                        "criterion": criterion,
                        "target": f"{source}, {target:.3f}",
                        "within": f"{loss:.0%}",
                        "runs": len(runs),
                        "hit": int(is_hit.sum()),
                        "median CPU of hits [s]": float(np.median(hits[is_hit]))
                        if is_hit.any()
                        else float("nan"),
                        "expected CPU [s]": expected_cost(hits, spent),
                        "per local solution": float(is_hit.sum() / max(tried, 1.0)),
                    }
                )
    return result


def dependence_lines(rows: Sequence[Row], reference: tuple[float, float], name: str) -> list[Line]:
    """The best of each bound, the other one at its reference."""
    varied, fixed = _varied(name, reference)
    kept = [row for row in rows if _place(row)[1 - varied] == fixed]
    result: list[Line] = []
    for value in sorted({_place(row)[varied] for row in kept}):
        line: Line = {NAMES[name]: value}
        for criterion in CRITERIA:
            of_value = [
                r for r in kept if _place(r)[varied] == value and r["criterion"] == criterion
            ]
            best = _best(of_value, criterion)
            line[criterion] = best
            if name == "amplitude_bound":
                line[f"{criterion} at_most"] = _best(
                    [r for r in kept if _place(r)[varied] <= value and r["criterion"] == criterion],
                    criterion,
                )
            amplitudes = {float(r[criterion]): float(r["largest_amplitude"]) for r in of_value}
            largest = amplitudes.get(best, float("nan"))
            line[f"{criterion} largest |a| [rad]"] = largest
        result.append(line)
    return result


def panels(rows: Sequence[Row], reference: tuple[float, float]) -> list[DependencePanel]:
    """Criterion by criterion, against amplitude bound and horizon."""
    result = []
    for criterion in CRITERIA:
        for name, label in NAMES.items():
            varied, fixed = _varied(name, reference)
            kept = [
                r for r in rows if r["criterion"] == criterion and _place(r)[1 - varied] == fixed
            ]
            bounds = np.array(sorted({_place(r)[varied] for r in kept}))
            within = (lambda v, b: v <= b) if name == "amplitude_bound" else (lambda v, b: v == b)
            result.append(
                DependencePanel(
                    xlabel=label,
                    ylabel=criterion,
                    bounds=np.array([_place(r)[varied] for r in kept]),
                    values=np.array([float(r[criterion]) for r in kept]),
                    best_bounds=bounds,
                    best_values=np.array(
                        [
                            _best([r for r in kept if within(_place(r)[varied], b)], criterion)
                            for b in bounds
                        ]
                    ),
                )
            )
    return result


def _place(row: Row) -> tuple[float, float]:
    return float(row["amplitude_bound"]), float(row["horizon"])


def _varied(name: str, reference: tuple[float, float]) -> tuple[int, float]:
    """Which part of a place varies, and what the other is fixed at."""
    index = list(NAMES).index(name)
    return index, reference[1 - index]


def _best(rows: Sequence[Row], criterion: str) -> float:
    values = [float(row[criterion]) for row in rows if row["criterion"] == criterion]
    return (min if criterion == "J_k" else max)(values, default=float("nan"))


def _cost(target: float, loss: float, criterion: str) -> float:
    """The cost [decades] at which a design is within a loss of a target."""
    bare = float(np.log10(target)) if criterion == "J_k" else -target
    return bare + float(np.log10(1 + loss))


def _local_solutions(status: str) -> int:
    """How many a run made, from its status: "... N local solutions; ..."."""
    words = status.split()
    return int(words[words.index("local") - 1])


def _run_line(row: Row) -> Line:
    shown = ("amplitude_bound", "horizon", "criterion", "seed", "cpu_s")
    line: Line = {key: row[key] for key in shown}
    for key in ("J_k", "J_d", "J_k_continuous", "J_d_continuous", "certified_violation"):
        line[key] = float(row[key]) if row[key] else float("nan")
    return line | {"status": row["status"]}
