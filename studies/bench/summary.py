"""From the bench's lines to rates: what is found, what is invented, how large it has to be."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from oed.report.table import markdown_table
from studies.bench.forms import FORMS, OUTSIDE
from studies.bench.plan import GROUPS, MANY_JOINTS, TWO_JOINTS
from studies.bench.rates import (
    BenchRow,
    Rate,
    done,
    is_alarm,
    is_class_right,
    is_exact,
    is_found,
    is_quiet,
    rate,
)
from studies.bench.reliability import reliability
from studies.bench.score import AMBIGUOUS, NOTHING

NOTHING_NAMED = "nothing"
FREE_TERM = "no name claimed"
SIZE_EDGES = (0.0, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, np.inf)
# What a diagnosis may take, two at a time on two cores, each on one [s].
PATIENCE = (("two", TWO_JOINTS, 30.0), ("six or seven", MANY_JOINTS, 300.0))


def group_table(rows: Sequence[BenchRow]) -> list[dict[str, str | int]]:
    """A line a group."""
    table = []
    for group in GROUPS:
        all_of_it = [row for row in rows if row["group"] == group]
        if not all_of_it:
            continue
        judged = done(all_of_it)
        clean = group == "clean"
        table.append(
            {
                "group": group,
                "cases": len(all_of_it),
                "failed": len(all_of_it) - len(judged),
                "right, nothing else": str(rate(judged, is_quiet if clean else is_exact)),
                "right": str(rate(judged, is_quiet if clean else is_found)),
                "right class": str(rate(judged, is_quiet if clean else is_class_right)),
                "a false name": str(rate(judged, lambda row: int(row["extra"]) > 0)),
                "ambiguous": str(rate(judged, lambda row: row["verdict"] == AMBIGUOUS)),
            }
        )
    return table


def error_table(rows: Sequence[BenchRow]) -> list[dict[str, str | int | float]]:
    """Errors on the test recordings, a line a group."""
    table = []
    for group in GROUPS:
        judged = done([row for row in rows if row["group"] == group])
        if not judged:
            continue
        floor, before, removed = (
            np.array([float(row[column]) for row in judged])
            for column in ("after_to_floor", "after_to_before", "removed")
        )
        table.append(
            {
                "group": group,
                "cases": len(judged),
                "after / floor, median": float(np.median(floor)),
                "after / floor, 90 %": float(np.quantile(floor, 0.9)),
                "excess removed, median": float(np.nanmedian(removed))
                if np.isfinite(removed).any()
                else float("nan"),
                "after / before, worst": float(before.max()),
                "worse than before": str(Rate(int((before > 1 + 1e-6).sum()), len(before))),
                "seconds, median": float(np.median([float(row["seconds"]) for row in judged])),
            }
        )
    return table


def time_table(rows: Sequence[BenchRow]) -> list[dict[str, str | int | float]]:
    """How long a diagnosis took, by the state of its code and the joints of the arm."""
    table, judged = [], done(rows)
    for code in dict.fromkeys(row["code"] for row in judged):
        for joints, robots, limit in PATIENCE:
            own = [r for r in judged if r["code"] == code and r["robot"] in robots]
            if not own:
                continue
            seconds = np.array([float(row["seconds"]) for row in own])
            table.append(
                {
                    "state": f"`{code}`",
                    "joints": joints,
                    "cases": len(own),
                    "median [s]": float(np.median(seconds)),
                    "longest [s]": float(seconds.max()),
                    "up to [s]": limit,
                    "in time": str(Rate(int((seconds <= limit).sum()), len(own))),
                }
            )
    return table


def clean_table(rows: Sequence[BenchRow]) -> list[dict[str, str]]:
    """False alarms on clean data, by noise and repetition."""
    clean = done([row for row in rows if not row["hidden"]])
    kinds = sorted({(row["noise"], row["repeated"]) for row in clean})
    table = []
    for noise, repeated in kinds:
        of_kind = [r for r in clean if (r["noise"], r["repeated"]) == (noise, repeated)]
        table.append({"noise": noise, "repeated": repeated} | _alarms(of_kind))
    return [*table, {"noise": "all", "repeated": ""} | _alarms(clean)] if clean else []


def _alarms(rows: Sequence[BenchRow]) -> dict[str, str]:
    return {
        "something named": str(rate(rows, is_alarm)),
        "not “nothing found”": str(rate(rows, lambda row: not is_quiet(row))),
    }


def confusion(rows: Sequence[BenchRow]) -> Counter[tuple[str, str]]:
    """How often each name was claimed where each effect was hidden alone."""
    counts: Counter[tuple[str, str]] = Counter()
    for row in done(rows):
        if "+" in row["hidden"]:
            continue
        truth = FORMS[row["hidden"]].name if row["hidden"] else NOTHING_NAMED
        names = sorted({claim.split("@")[0] for claim in row["claims"].split()})
        if not names:
            names = [NOTHING_NAMED if row["verdict"] == NOTHING else FREE_TERM]
        counts.update((truth, name) for name in names)
    return counts


def form_table(rows: Sequence[BenchRow]) -> list[dict[str, str | int]]:
    """A line for each form that was hidden alone at its realistic size."""
    table = []
    single = [row for row in done(rows) if row["hidden"] and "+" not in row["hidden"]]
    single = [row for row in single if row["group"] != "size"]
    for key, form in FORMS.items():
        of_form = [row for row in single if row["hidden"] == key]
        if not of_form:
            continue
        table.append(
            {
                "hidden": form.name if form.name != OUTSIDE else f"{key} (outside)",
                "formula": key,
                "cases": len(of_form),
                "right, nothing else": sum(map(is_exact, of_form)),
                "right": sum(map(is_found, of_form)),
                "right class": sum(map(is_class_right, of_form)),
                "size / noise, least": min(float(row["size_in_noise"]) for row in of_form),
            }
        )
    return table


def detection(rows: Sequence[BenchRow]) -> list[dict[str, float | int]]:
    """Share right against the size of the effect in units of the noise, one effect hidden."""
    single = [row for row in done(rows) if row["hidden"] and "+" not in row["hidden"]]
    return _by_size([row for row in single if FORMS[row["hidden"]].name != OUTSIDE])


def pair_detection(rows: Sequence[BenchRow]) -> list[dict[str, float | int]]:
    """Share of pairs of which both are right against the size of the smaller of the two."""
    return _by_size([row for row in done(rows) if "+" in row["hidden"]])


def _by_size(rows: Sequence[BenchRow]) -> list[dict[str, float | int]]:
    sizes = np.array([float(row["smaller_in_noise"]) for row in rows])
    table = []
    for low, high in pairwise(SIZE_EDGES):
        inside = [row for row, s in zip(rows, sizes, strict=True) if low <= s < high]
        if not inside:
            continue
        found, noticed = rate(inside, is_class_right), rate(inside, lambda r: not is_quiet(r))
        table.append(
            {
                "from": low,
                "to": high,
                "median": float(np.median(sizes[(sizes >= low) & (sizes < high)])),
                "cases": len(inside),
                "noticed": noticed.hits / noticed.cases,
                "right": found.hits / found.cases,
                "lower": found.interval[0],
                "upper": found.interval[1],
            }
        )
    return table


def coverage(rows: Sequence[BenchRow]) -> Rate:
    """How many of the 95 % intervals hold the injected value."""
    judged = done(rows)
    return Rate(
        sum(int(row["covered"]) for row in judged), sum(int(row["compared"]) for row in judged)
    )


def _states(rows: Sequence[BenchRow]) -> str:
    """On which states of the diagnosis' code the lines were made."""
    counts = Counter(row["code"] for row in done(rows))
    each = ", ".join(f"`{code}` ({count})" for code, count in counts.items())
    return f"{len(counts)} state(s) of the diagnosis' code: {each}" if counts else "none judged yet"


def _table(lines: Sequence[Mapping[str, str | int | float]], *, digits: int = 4) -> str:
    return markdown_table(lines, digits=digits) if lines else "No case yet.\n"


def page(rows: Sequence[BenchRow], note: str) -> str:
    """The summary as Markdown."""
    failures = Counter(row["status"] for row in rows if row["status"] != "done")
    parts = [
        "# The undeclared-effect bench\n",
        note,
        f"\n{len(rows)} data sets, {len(done(rows))} judged; {_states(rows)}.\n",
        "## By question\n",
        (
            "“Right” is the right name at the right joint, outside the catalogue the right "
            "coordinates; “right class” also counts delay for lag and a right rival in an ambiguous "
            "verdict. Intervals of 95 %, Clopper–Pearson.\n"
        ),
        markdown_table(group_table(rows)),
        "\n## Nothing hidden\n",
        _table(clean_table(rows)),
        "\n## Names by their stated probability\n",
        (
            "Right where a hidden effect accounts for the name: as itself, a delay for a lag, or one of the "
            "rivals that the verdict leaves open.\n"
        ),
        _table(reliability(rows), digits=4),
        "\n## Test error\n",
        "The largest ratio over the joints, by the diagnosis' own errors and floor.\n",
        _table(error_table(rows)),
        f"\n95 % intervals that hold the injected value: {coverage(rows)}.\n",
        "\n## Time\n",
        (
            "Wall clock of a whole diagnosis on one core, with whatever else the machine did beside it; "
            "recordings of 10,000 to 15,000 samples. Each state ran on the machine of its day.\n"
        ),
        _table(time_table(rows)),
        "\n## By what was hidden\n",
        _table(form_table(rows)),
        "\n## Against size\n",
        (
            "Size: root mean square of what the base model cannot absorb, fitted without noise, "
            "per standard deviation of the noise, at the joint where it is largest.\n"
        ),
        _table(detection(rows), digits=3),
        "\n## Two at once, against the smaller\n",
        "The size of the smaller of the two, each hidden alone on the same motions.\n",
        _table(pair_detection(rows), digits=3),
    ]
    if failures:
        lines = "\n".join(f"- {count} × {status}" for status, count in failures.most_common())
        parts += ["\n## Cases without a diagnosis\n", lines + "\n"]
    return "\n".join(parts)
