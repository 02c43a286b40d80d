"""The best motion known of a problem, over all studies: what an optimiser's runs are held to."""

from __future__ import annotations

import numpy as np

from oed.report.table import Row, number_of, read_csv
from studies.data_folders import REPOSITORY
from studies.optimiser_comparison import Cell

# What an earlier state of this study reached in 2.5 CPU seconds, the best of 30 seeds.
EARLIER = {("paper", "J_k"): 5.2705, ("paper", "J_d"): 19.92238, ("panda", "J_d"): 193.998}
BOUND_DESIGNS = REPOSITORY / "results/optimality_bound/designs.csv"
SAME_CLASS = "fourier, 5 harmonics, 10 s"
TRAJECTORIES = REPOSITORY / "results/compare_trajectories/runs.csv"


def best_known(cell: Cell) -> tuple[float, str]:
    """The lowest cost known of a cell over all studies, and where it is from."""
    found = [(EARLIER.get((cell.problem, cell.criterion)), "an earlier state of this study")]
    if cell.problem == "paper" and BOUND_DESIGNS.is_file():
        same = [row for row in read_csv(BOUND_DESIGNS) if row["class"] == SAME_CLASS]
        if cell.criterion == "J_d" and same:
            best = max(number_of(row["J_d"]) for row in same)
            found.append((best, "results/optimality_bound"))
    costs = [
        (float(np.log10(value)) if cell.criterion == "J_k" else -value, source)
        for value, source in found
        if value is not None
    ]
    costs += [
        (run.history[-1].cost, f"this study: {run.optimiser}, seed {run.seed}")
        for run in cell.runs
        if run.history
    ]
    return min(costs)


def target_row(cell: Cell, cost: float, source: str) -> Row:
    """The best known value, and where it is from."""
    return {
        "problem": cell.problem,
        "criterion": cell.criterion,
        "best known": f"{cell.value(cost):.6g}",
        "from": source,
    }


def other_classes() -> str:
    """What richer motions reach on the paper's problem, where that study has results."""
    if not TRAJECTORIES.is_file():
        return ""
    rows = [row for row in read_csv(TRAJECTORIES) if row["problem"] == "paper, J_k, 10 s"]
    best = min(rows, key=lambda row: number_of(row["value"]), default=None)
    if best is None:
        return ""
    return f"""
A class of motions can matter more than the optimiser: `{best["trajectory"]}` reaches J_k {number_of(best["value"]):.3f} on the paper's problem
(`results/compare_trajectories`).
"""
