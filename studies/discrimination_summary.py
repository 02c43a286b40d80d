"""What the study of rivals shows, in words, a table and a figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from scipy.stats import beta

from oed.report.discrimination_plots import plot_calibration
from oed.report.json_file import write_atomically
from oed.report.style import save_figure
from oed.report.table import markdown_table

LEVEL = 0.95
SEPARABLE = 0.95  # predicted chance of a decisive difference from which on a pair is separable
SEEN = 0.05  # predicted error rate from which on a case tests the prediction
AGREEMENT = 0.05  # between predicted and observed rate that is promised
Line = Mapping[str, str]


def clopper_pearson(hits: int, trials: int, level: float = LEVEL) -> tuple[float, float]:
    """Exact interval of a share (Clopper and Pearson 1934, Biometrika 26(4)).

    Args:
        hits: Successes.
        trials: Trials, at least one.
        level: Least coverage.
    """
    if not 0 <= hits <= trials or trials < 1:
        raise ValueError(f"{hits=} of {trials=}")
    tail = (1 - level) / 2
    lower = 0.0 if hits == 0 else float(beta.ppf(tail, hits, trials - hits + 1))
    upper = 1.0 if hits == trials else float(beta.ppf(1 - tail, hits + 1, trials - hits))
    return lower, upper


def agreement(rows: Sequence[Line], predicted: str, wrong: str, runs: str) -> dict[str, float]:
    """Mean predicted and observed rate over the cases, their difference and how sure it is.

    Args:
        rows: Finished cases.
        predicted: Column of the predicted rate.
        wrong: Column of the number of wrong choices.
        runs: Column of the number of draws.
    """
    p = np.array([float(row[predicted]) for row in rows])
    n = np.array([int(row[runs]) for row in rows])
    o = np.array([int(row[wrong]) for row in rows]) / n
    # Of the draws alone, by the rule of succession: no case is as sure as 0 of 16 looks.
    smooth = (o * n + 1) / (n + 2)
    spread = float(np.sqrt(np.sum(smooth * (1 - smooth) / n)) / len(p))
    far = [
        not low - AGREEMENT <= q <= high + AGREEMENT
        for q, (low, high) in zip(
            p,
            (clopper_pearson(int(k), int(m)) for k, m in zip(o * n + 0.5, n, strict=True)),
            strict=True,
        )
    ]
    return {
        "predicted": float(p.mean()),
        "observed": float(o.mean()),
        "difference": float((p - o).mean()),
        "half width": 1.96 * spread,
        "mean |difference|": float(np.abs(p - o).mean()),
        "largest |difference|": float(np.abs(p - o).max()),
        "beyond 5 points and chance": int(np.sum(far)),
    }


def write_summary(rows: Sequence[Line], planned: int, out: Path) -> None:
    """Leave summary.md and calibration.png in a folder.

    Args:
        rows: Cases that were tried.
        planned: Number of cases that the configuration asks for.
        out: The folder.
    """
    out.mkdir(parents=True, exist_ok=True)
    done = [row for row in rows if row["status"] == "done"]
    write_atomically(out / "summary.md", page(rows, planned))
    if done:
        panels = [_panel(done, *line) for line in (KINDS[0], KINDS[2])]
        save_figure(plot_calibration(panels), out / "calibration", ("png",))


KINDS = (
    ("Φ(−√λ/2), the rival fits better", "formula", "wrong_fit", "runs"),
    ("drawn, the rival fits better", "predicted_fit", "wrong_fit", "runs"),
    ("drawn, the rival is named", "predicted_name", "wrong_name", "runs"),
    (
        "drawn, the rival is named, with the designed motion",
        "designed_predicted",
        "designed_wrong_name",
        "designed_runs",
    ),
)


def page(rows: Sequence[Line], planned: int) -> str:
    """The result of so many planned cases in words and tables."""
    done = [row for row in rows if row["status"] == "done"]
    text = "# Rivals: predicted and observed error, and one motion that decides\n\n"
    if not done:
        return text + "No case is done.\n"
    table = [{"prediction": title, **agreement(done, p, w, n)} for title, p, w, n in KINDS]
    named = agreement(done, *KINDS[2][1:])
    close = [r for r in done if float(r["predicted_name"]) >= SEEN or int(r["wrong_name"])]
    mean = "agree" if abs(named["difference"]) <= AGREEMENT else "do not agree"
    every = "every case does" if not named["beyond 5 points and chance"] else "not every case does"
    text += (
        f"{len(done)} of {planned} planned cases ({len(rows) - len(done)} failed); a case hides "
        "one effect of a pair in an arm, and draws the noise anew end to end. Rates are means over "
        "the cases; `difference` is predicted less observed, with the half width of its 95 % "
        "interval from the draws alone. The last column counts cases whose prediction lies more "
        "than 5 points outside the Clopper–Pearson interval of what was observed.\n\n"
        f"**In the mean over the cases the predicted and the observed rate of naming the wrong "
        f"rival {mean} within 5 points, {every}**: {named['predicted']:.1%} and "
        f"{named['observed']:.1%}; case by case they differ by {named['mean |difference|']:.1%} in "
        f"the mean and {named['largest |difference|']:.1%} at most. "
        f"Only {len(close)} cases test this: in the others less than 5 % is predicted and nothing "
        "wrong was observed, for the pair is told apart as soon as its effect is seen at all. "
        f"A case has {done[0]['runs']} draws on the motion at hand and {done[0]['designed_runs']} "
        "executions of the designed one, too few to tell 5 points in a single case.\n\n"
        "A prediction takes the favourite's formula for the truth. It fails where a candidate's "
        "columns do not reproduce its own effect to within the noise.\n\n"
    )
    text += markdown_table(table, digits=3) + "\n" + _resolved(done) + "\n## By pair\n\n"
    return text + markdown_table([_line(row) for row in done], digits=3)


def _resolved(done: Sequence[Line]) -> str:
    separable = [row for row in done if float(row["designed_resolved"]) >= SEPARABLE]
    lines = ["## One designed motion\n"]
    if not separable:
        return lines[0] + "\nNo pair is separable.\n"
    hits = sum(int(row["first_decided"]) for row in separable)
    low, high = clopper_pearson(hits, len(separable))
    runs = sum(int(row["designed_runs"]) for row in separable)
    again = sum(int(row["designed_decided"]) for row in separable)
    misled = sum(int(row["designed_misled"]) for row in separable)
    before = sum(int(row["at_hand_decided"]) for row in separable)
    at_hand = sum(int(row["runs"]) for row in separable)
    lines.append(
        f"{len(separable)} of {len(done)} pairs are separable: with the designed motion the predicted "
        f"chance of a decisive difference is {SEPARABLE:.0%} or more. Its first execution resolves {hits} of them, "
        f"**{hits / len(separable):.0%}** (95 % interval {low:.0%} to {high:.0%}): the hidden effect "
        f"leads by a decisive difference of evidence. Over all executions {again} of {runs} are "
        f"resolved ({again / runs:.0%}) and {misled} decided wrongly. Without the designed motion "
        f"the recordings decide {before} of {at_hand} times ({before / at_hand:.0%}).\n"
    )
    return "\n".join(lines)


def _line(row: Line) -> dict[str, str | float]:
    runs, designed = int(row["runs"]), int(row["designed_runs"])
    return {
        "arm": row["robot"],
        "hidden": row["hidden"].replace("_", " "),
        "rival": row["rival"].replace("_", " "),
        "noise": row["noise"],
        "λ": float(row["separation"]),
        "Φ": float(row["formula"]),
        "fits better": int(row["wrong_fit"]) / runs,
        "predicted name": float(row["predicted_name"]),
        "observed name": int(row["wrong_name"]) / runs,
        "designed λ": float(row["designed_separation"]),
        "designed predicted": float(row["designed_predicted"]),
        "designed observed": int(row["designed_wrong_name"]) / designed,
        "resolution predicted": float(row["designed_resolved"]),
        "resolved": f"{row['designed_decided']}/{designed}",
    }


def _panel(
    done: Sequence[Line], title: str, predicted: str, wrong: str, runs: str
) -> tuple[str, list[tuple[float, float, float, float]]]:
    points = []
    for row in done:
        hits, trials = int(row[wrong]), int(row[runs])
        points.append((float(row[predicted]), hits / trials, *clopper_pearson(hits, trials)))
    return title, points
