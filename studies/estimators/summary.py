"""The lines as a page that is read in two minutes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import median

from oed.report.table import MISSING, Row, markdown_table

Line = Mapping[str, str]
BEST = 1.1  # times the least error of a condition, up to which a method counts as among the best


def good(lines: Sequence[Line]) -> list[Line]:
    """Those that have numbers."""
    return [line for line in lines if line["status"] == "ok"]


def page(lines: Sequence[Line]) -> str:
    """The summary."""
    done = good(lines)
    arms = list(dict.fromkeys(line["arm"] for line in done))
    parts = [
        "# Estimators",
        (
            "Simulated arms under position control, one factor at a time around a base case (10 s, 250 Hz, white "
            "torque noise, 17-bit encoders, the right friction law, a full motion). `error`: rms of the predicted "
            "less the true rigid-body and friction torque on another motion, over each joint's rms torque; `bias` "
            "of it the part that all logs share. `held`: share of 95 % intervals that hold the truth. Iterative "
            "methods start from numbers 10 % off, and know controller and reference. ours: signal processing "
            "of `oed identify`; the linear others: 10 Hz low-pass, central differences, decimation."
        ),
        "![Error](error.png)",
        "![Coverage](coverage.png)",
        "![Bias and spread](bias.png)",
        "## In short",
        markdown_table([_overall(method, done) for method in _methods(done)]),
        "`error`: over that of IDIM-LS on the same logs, the median and the worst over arms and conditions.",
        "## What others found",
        BIRDY,
        "\n".join(f"- {text}" for text in findings(done)),
        "## Who is best where",
        markdown_table([_ranking(arm, condition, done) for arm, condition in _pairs(done)]),
    ]
    for arm in arms:
        own = [line for line in done if line["arm"] == arm]
        parts += [f"## {arm}", markdown_table([_row(line) for line in own])]
    failed = [line for line in lines if line["status"] != "ok"]
    if failed:
        parts += [
            "## No estimate",
            "\n".join(
                f"- {line['arm']}, {line['condition']}, {line['method']}: {line['status']}"
                for line in failed
            ),
        ]
    return "\n\n".join(parts) + "\n"


BIRDY = (
    "Leboutet and others (2021) compare seventeen such estimators on a simulated and a real TX40 and RV2SQ. What "
    "they and the methods' authors expect, and what these rows say:"
)


def findings(lines: Sequence[Line]) -> list[str]:
    """Each expectation with the figures that speak for it or against it."""
    said = []
    for name, quantity, methods, conditions in EXPECTED:
        for method in methods:
            ratios = [
                ratio
                for condition in conditions
                for ratio in ratios_of(
                    method, [x for x in lines if x["condition"] == condition], quantity
                )
            ]
            if ratios:
                least, most = min(ratios), max(ratios)
                word = "yes" if most < SAME[0] else "no" if least > SAME[0] else "in part"
                if name == LOSES:
                    word = {"yes": "no", "no": "yes"}.get(word, word)
                said.append(
                    f"{name}: {method}, {word}: {least:.2g} to {most:.2g} times the {quantity} of {USUAL} "
                    f"({', '.join(conditions)})"
                )
    same = ratios_of("total LS", lines)
    if same:
        word = "yes" if median(same) > SAME[0] else "no"
        said.append(
            f"total least squares gain nothing over least squares: {word}: {min(same):.2g} to "
            f"{max(same):.2g} times the error, the median {median(same):.2g}"
        )
    slow, usual = (_seconds(lines, m) for m in ("output error", USUAL))
    if slow and usual:
        said.append(
            f"output error is dear: {slow / usual:.0f} times the seconds of {USUAL}, with machine code"
        )
    return said


USUAL = "IDIM-LS"
SAME = (0.95, 1.05)  # between which two errors are alike: a tenth of the spread of so few logs
LOSES = "and loses that where something moves the arm, or the model is wrong"
EXPECTED = (
    (
        "simulated regressors take away the bias that noisy positions give",
        "bias",
        ("IDIM-IV", "DIDIM", "ours, HAC"),
        ("coarse encoder",),
    ),
    (
        "output error is the most accurate where the controller is known and the model is right",
        "error",
        ("output error",),
        ("base", "coloured noise", "coarse encoder"),
    ),
    (
        LOSES,
        "error",
        ("output error",),
        ("felt noise", "wrong friction"),
    ),
    (
        "bodies that can exist, or few directions, help a poor motion",
        "error",
        ("feasible", "feasible, prior", "ours, HAC", "ridge", "truncated SVD"),
        ("poor motion",),
    ),
)


def ratios_of(method: str, lines: Sequence[Line], quantity: str = "error") -> list[float]:
    """Errors of a method, or its bias, over those of the usual one, a number an arm and condition."""
    error = {(x["arm"], x["condition"], x["method"]): float(x[quantity]) for x in lines}
    return [
        value / error[arm, condition, USUAL]
        for (arm, condition, own), value in error.items()
        if own == method and (arm, condition, USUAL) in error
    ]


def _methods(lines: Sequence[Line]) -> list[str]:
    return list(dict.fromkeys(line["method"] for line in lines))


def _seconds(lines: Sequence[Line], method: str) -> float | None:
    own = [float(line["seconds"]) for line in lines if line["method"] == method]
    return median(own) if own else None


def _overall(method: str, lines: Sequence[Line]) -> Row:
    own = [line for line in lines if line["method"] == method]
    ratios = ratios_of(method, lines)
    count = sum(int(line["intervals"]) for line in own)
    return {
        "method": method,
        "error, median": median(ratios) if ratios else None,
        "error, worst": max(ratios) if ratios else None,
        "held": sum(int(line["covered"]) for line in own) / count if count else None,
        "logs without an estimate": sum(int(line["failed"]) for line in own),
        "s a log": _seconds(lines, method),
    }


def _pairs(lines: Sequence[Line]) -> list[tuple[str, str]]:
    return list(dict.fromkeys((line["arm"], line["condition"]) for line in lines))


def _ranking(arm: str, condition: str, lines: Sequence[Line]) -> Row:
    own = [line for line in lines if (line["arm"], line["condition"]) == (arm, condition)]
    least = min(float(line["error"]) for line in own)
    best = [line["method"] for line in own if float(line["error"]) <= BEST * least]
    mine = next((line for line in own if line["method"] == "ours, HAC"), None)
    usual = next((line for line in own if line["method"] == "IDIM-LS"), None)
    return {
        "arm": arm,
        "condition": condition,
        "within 10 % of the best": ", ".join(best),
        "best [%]": 100 * least,
        "ours [%]": 100 * float(mine["error"]) if mine else None,
        "IDIM-LS [%]": 100 * float(usual["error"]) if usual else None,
        "ours, held": held(mine) if mine else None,
        "IDIM-LS, held": held(usual) if usual else None,
    }


def held(line: Line) -> float | None:
    """Share of intervals that hold the truth; None where none is told."""
    count = int(line["intervals"])
    return int(line["covered"]) / count if count else None


def _row(line: Line) -> Row:
    share = held(line)
    return {
        "condition": line["condition"],
        "method": line["method"],
        "error [%]": 100 * float(line["error"]),
        "bias [%]": 100 * float(line["bias"]),
        "spread [%]": 100 * float(line["spread"]),
        "held": MISSING if share is None else f"{share:.2f} of {line['intervals']}",
        "failed": f"{line['failed']} of {line['draws']}",
        "s a log": float(line["seconds"]),
    }
