"""What a comparison of classes of motions says, and what would have refuted it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy import stats

from oed.report.table import Row, markdown_table, number_of, read_csv
from studies.data_folders import REPOSITORY

LEVEL = 0.95
# Of the information about every parameter, in the geometric mean: as much as two percent more
# samples would tell.
MATTERS = 0.02
BOUNDS = REPOSITORY / "results/optimality_bound/bounds.csv"
RIVALS = "fourier"

Rows = Sequence[Mapping[str, str]]


def summarise(rows: Rows, seconds: float) -> str:
    """The page of the study."""
    good = [row for row in rows if row["status"] == "ok"]
    problems = list(dict.fromkeys(row["problem"] for row in good))
    failed = len(rows) - len(good)
    arms = [problem for problem in problems if not problem.startswith("paper")]
    cells = [cell for problem in problems for cell in _cells(_of(good, problem))]
    text = f"""\
# Which class of motions tells most?

{len(good)} designs, {failed} more without a proof that limits are kept, {seconds:g} CPU seconds each by the interior-point
optimiser, one a seed and class. `fourier N` has N harmonics, `collocation N` piecewise-linear acceleration of N
segments. `value` is J_k for the problems named so, else J_d = log10 det Lambda at
the problem's instants; all limits are proven for all t. Motions of the arms start and end at rest; the default has
5 harmonics.

{markdown_table(cells)}"""
    if arms:
        text += f"""
## Arms of six and seven joints

Said before the study was run: on an arm a class beats Fourier series if, seed by seed, it gives at least {MATTERS:.0%}
more information about every parameter (geometric mean, 10^(difference of J_d / base parameters)) than the number of
harmonics that did best, by the {LEVEL:.0%} t interval of the paired differences; it does not win if that interval
reaches below, and loses if all of it is below 1. Choosing the best harmonics by the same seeds favours the series.

{markdown_table([verdict for problem in arms for verdict in _verdicts(_of(good, problem))])}"""
    if len(arms) < len(problems):
        text += f"""
## The paper's problem

The paper's limits on position, velocity and acceleration, no rest at the ends. D-efficiency is certified: against
the lowest bound of `results/optimality_bound`, in continuous time.

{markdown_table([_mark(_of(good, problem), name) for problem in problems if problem not in arms for name in _classes(_of(good, problem))])}"""
    return text


def _of(rows: Rows, problem: str) -> Rows:
    return [row for row in rows if row["problem"] == problem]


def _classes(rows: Rows) -> list[str]:
    return list(dict.fromkeys(row["trajectory"] for row in rows))


def _values(rows: Rows, name: str) -> dict[str, float]:
    """Value of a class by seed."""
    return {row["seed"]: float(row["value"]) for row in rows if row["trajectory"] == name}


def _cells(rows: Rows) -> list[Row]:
    cells: list[Row] = []
    for name in _classes(rows):
        own = [row for row in rows if row["trajectory"] == name]
        values = np.array([float(row["value"]) for row in own])
        cells.append(
            {
                "problem": own[0]["problem"],
                "class": name,
                "variables": int(float(own[0]["variables"])),
                "designs": len(own),
                "mean value": round(float(values.mean()), 3),
                "least": round(float(values.min()), 3),
                "greatest": round(float(values.max()), 3),
                "evaluations": int(np.mean([float(row["evaluations"]) for row in own])),
            }
        )
    return cells


def _verdicts(rows: Rows) -> list[Row]:
    """Each class that is no Fourier series against the best that is."""
    series = [name for name in _classes(rows) if name.startswith(RIVALS)]
    best = max(series, key=lambda name: np.mean(list(_values(rows, name).values())))
    rival, base = _values(rows, best), float(rows[0]["base"])
    verdicts: list[Row] = []
    for name in (name for name in _classes(rows) if name not in series):
        own = _values(rows, name)
        gains = np.array([own[seed] - rival[seed] for seed in own.keys() & rival.keys()]) / base
        low, high = interval(gains)
        verdicts.append(
            {
                "arm": rows[0]["problem"],
                "class": name,
                "against": best,
                "pairs": len(gains),
                "information": round(10 ** float(gains.mean()), 3),
                "from": round(10**low, 3),
                "to": round(10**high, 3),
                "verdict": judge(10**low, 10**high),
            }
        )
    return verdicts


def interval(differences: np.ndarray) -> tuple[float, float]:
    """The t interval of the mean of paired differences; everything for fewer than two."""
    if len(differences) < 2:
        return -np.inf, np.inf
    half = stats.t.ppf(0.5 + LEVEL / 2, len(differences) - 1) * stats.sem(differences)
    return float(differences.mean() - half), float(differences.mean() + half)


def judge(low: float, high: float) -> str:
    """The verdict on an interval of the ratio of information."""
    if low >= 1 + MATTERS:
        return "wins"
    if high < 1.0:
        return "loses"
    return "does not win"


def _mark(rows: Rows, name: str) -> Row:
    """The best of a class's designs, and all of them; efficiency where J_d was designed for."""
    own = [row for row in rows if row["trajectory"] == name]
    is_condition = "J_k" in own[0]["problem"]
    key = "J_k" if is_condition else "J_d_continuous"
    values = [float(row[key]) for row in own]
    best = min(values) if is_condition else max(values)
    efficiency: float | str = ""
    if not is_condition and BOUNDS.is_file():
        bounds = read_csv(BOUNDS)
        least = min(number_of(row["J_d_bound"]) for row in bounds)
        efficiency = round(10 ** ((best - least) / float(own[0]["base"])), 4)
    return {
        "problem": own[0]["problem"],
        "class": name,
        "best of seeds": round(best, 3),
        "median": round(float(np.median(values)), 3),
        "D-efficiency of the best": efficiency,
        "worst violation": max(float(row["certified_violation"]) for row in own),
    }
