"""results/paper/summary.md, in plain words made from the measured rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from oed.report.table import Cell, Row, markdown_table, number_of
from studies.paper_experiment import values as paper
from studies.paper_experiment.finding import Finding


@dataclass(frozen=True)
class PaperRows:
    """All tables of the study."""

    comparison: Sequence[Row]
    horizons: Sequence[Row]
    terms: Sequence[Row]
    processing: Sequence[Row]
    energy: Sequence[Row]
    monte_carlo: Sequence[Row]
    claims: Sequence[Finding]
    drake: Sequence[Row]
    horizon: float
    samples: int
    experiments: int


def summarise(rows: PaperRows) -> str:
    """The summary as Markdown."""
    return "\n".join(
        [
            *_head(rows),
            *_errors(rows),
            *_designs(rows),
            *_claims(rows),
            *_processing(rows),
            *_energy(rows),
            *_monte_carlo(rows),
            *_comparison(rows),
        ]
    )


def _head(rows: PaperRows) -> list[str]:
    drake = rows.drake[0]
    return [
        "# The paper's experiment, in simulation",
        "",
        (
            "The IMI arm cannot be had. It is simulated with the parameters that the paper estimated on its "
            "J_k-optimal trajectory as the truth, the paper's observer, sampling and filter, gains designed "
            "for its specification, resolvers, and a torque disturbance whose level is calibrated so that the "
            'variances over 20 repetitions of the J_k trajectory are the paper\'s. "Plain" friction is the '
            'paper\'s Coulomb and viscous law; "rich" adds what its authors suspected: a rise towards '
            "standstill, presliding, thinning viscous friction and motor ripple. How rich is our choice, "
            "not a measurement."
        ),
        "",
        (
            f"The arm is a Drake MultibodyPlant in a Diagram; the hundreds of experiments below run on a "
            f"compiled loop of the same equations, which differs from Drake by at most "
            f"{_number(drake['position'])} rad and {_number(drake['command'])} N m "
            f"over {_number(drake['duration'])} s."
        ),
        "",
    ]


def _errors(rows: PaperRows) -> list[str]:
    find = {(r["design"], r["quantity"]): r for r in rows.comparison}
    lines = ["## Relative errors", ""]
    for design in ("J_k", "J_d"):
        cells = []
        for name in ("estimation", "validation", "test"):
            for j in (1, 2):
                row = find[design, f"relative rms, {name} set, joint {j}"]
                numbers = (row["paper"], row["reproduced"], row["with the paper's friction"])
                shown = " | ".join(f"{_number(number)} %" for number in numbers)
                cells.append(f"{name} {j}: {shown}")
        lines.append(
            f"- {design}, paper | rich friction | plain friction: " + "; ".join(cells) + "."
        )
    floor = [
        r
        for r in rows.processing
        if r["friction"] == "plain" and r["processing"] == "parallel" and r["design"] == "J_k, GA"
    ]
    if floor:
        row = floor[0]
        is_noise = all(
            number_of(row[f"rms residual {j} [N m]"])
            < 1.05 * number_of(row[f"noise floor {j} [N m]"])
            for j in (1, 2)
        )
        lines.append(
            "- With plain friction and both sides of the equation filtered alike, the residual is "
            f"{_number(row['rms residual 1 [N m]'])} and {_number(row['rms residual 2 [N m]'])} N m, "
            f"the noise between repetitions {_number(row['noise floor 1 [N m]'])} and "
            f"{_number(row['noise floor 2 [N m]'])} N m (part of which the measured motion explains): "
            + ("what is left is noise." if is_noise else "more than noise is left.")
        )
    lines += [
        _distance(find["J_d", "relative rms, estimation set, joint 1"]),
        (
            f"- The paper's own residuals ({paper.RMS[0][0][0]} and {paper.RMS[0][0][1]} N m) are smaller "
            f"than the standard deviations it measured ({paper.VARIANCES[0][0] ** 0.5:.2f} and "
            f"{paper.VARIANCES[0][1] ** 0.5:.2f} N m). This is consistent only if the variance was taken "
            "before the filter, or drifts over the 20 repetitions; here it is taken before the filter."
        ),
        "",
    ]
    return lines


def _distance(row: Row) -> str:
    """Whether the paper's error of joint 1 on the J_d trajectory comes back."""
    ratio = number_of(row["paper"]) / number_of(row["reproduced"])
    squared_torque = (paper.RMS[1][0][0] / paper.RELATIVE[1][0][0]) ** 2
    share = paper.VARIANCES[1][0] / squared_torque
    came = "comes" if 0.5 < ratio < 2 else "does not come"
    return (
        f"- The paper's error of joint 1 on its J_d trajectory {came} back: it is {ratio:.1f} times ours. "
        f"The paper measured a variance of {paper.VARIANCES[1][0]} N^2 m^2 there, {100 * share:.0f} % of "
        "its mean squared torque; a disturbance that does not depend on the motion, as here, gives "
        "both trajectories the same variance."
    )


def _designs(rows: PaperRows) -> list[str]:
    return [
        "## Designs, and the horizon that the paper does not state",
        "",
        (
            f"J_k is cond(Lambda); J_d is log10 det(Lambda) at {rows.samples} instants and two joints, and "
            "grows with their number: compare its column at half the instants. The "
            f"horizon used below, {_number(rows.horizon)} s, is the one whose median J_k is nearest to the "
            f"paper's {paper.J_K}."
        ),
        "",
        markdown_table(list(rows.horizons)),
        "",
        markdown_table(list(rows.terms)),
        "",
    ]


def _claims(rows: PaperRows) -> list[str]:
    lines = ["## Claims", "", f"95 % intervals over {rows.experiments} experiments a cell.", ""]
    for claim in dict.fromkeys(f.claim for f in rows.claims):
        findings = [f for f in rows.claims if f.claim == claim]
        verdicts = {v: sum(f.verdict == v for f in findings) for v in _VERDICTS}
        lines.append(f"- **{claim}**: {overall(findings)} ({_counted(verdicts)}).")
        lines += [f"  - {_sentence(f)}" for f in findings[:_MOST_SENTENCES]]
        if len(findings) > _MOST_SENTENCES:
            lines.append(f"  - and {len(findings) - _MOST_SENTENCES} more in claims.csv.")
    return [*lines, ""]


_VERDICTS = ("confirmed", "refuted", "undecided")
_MOST_SENTENCES = 12


def overall(findings: Sequence[Finding]) -> str:
    """One word for several findings on one claim: mixed where they contradict each other."""
    verdicts = {f.verdict for f in findings}
    if {"confirmed", "refuted"} <= verdicts:
        return "it depends"
    if "confirmed" in verdicts:
        return "confirmed" if verdicts == {"confirmed"} else "confirmed in part"
    return "refuted" if "refuted" in verdicts else "undecided"


def _counted(verdicts: dict[str, int]) -> str:
    return ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items() if count)


def _sentence(f: Finding) -> str:
    where = "" if f.friction == "-" else f" ({f.friction} friction, {f.processing} signals)"
    unit = "" if f.unit == "-" else f" {f.unit}"
    interval = "" if f.lower == f.upper else f" [{_number(f.lower)}, {_number(f.upper)}]"
    return f"{f.statement}{where}: {_number(f.value)}{interval}{unit} – {f.verdict}"


def _processing(rows: PaperRows) -> list[str]:
    return [
        "## What the processing of the signals costs",
        "",
        (
            '"online" is the paper to the letter, "aligned" filters the position too, "zero_phase" is '
            'what the authors wanted, "parallel" filters the regressor\'s columns like the torque, '
            '"spectral" differentiates the harmonics of a periodic motion exactly and leaves the torque '
            "unfiltered."
        ),
        "",
        markdown_table(list(rows.processing)),
        "",
    ]


def _energy(rows: PaperRows) -> list[str]:
    lines = ["## Energy model beside Newton–Euler", ""]
    for friction in dict.fromkeys(r["friction"] for r in rows.energy):
        for way in dict.fromkeys(r["processing"] for r in rows.energy):
            cell = [r for r in rows.energy if (r["friction"], r["processing"]) == (friction, way)]
            agree = sum(bool(r["agree"]) for r in cell)
            bias = [
                sum(
                    ((number_of(r[k]) - number_of(r["truth"])) / number_of(r["truth"])) ** 2
                    for r in cell
                )
                for k in ("Newton-Euler", "energy")
            ]
            torque, energy = ((100 * (b / len(cell)) ** 0.5) for b in bias)
            better = "energy" if energy < torque else "Newton-Euler"
            lines.append(
                f"- {friction} friction, {way} signals: {agree} of {len(cell)} parameters agree within "
                f"their intervals; rms bias {torque:.1f} % by Newton-Euler, {energy:.1f} % by energy: "
                f"{better} is less biased."
            )
    return [*lines, "", markdown_table(list(rows.energy)), ""]


def _monte_carlo(rows: PaperRows) -> list[str]:
    columns = [
        "friction",
        "design",
        "processing",
        "rms bias [% of truth]",
        "rms std [% of truth]",
        *(f"relative {s} {j} [%]" for s in ("validation", "test") for j in (1, 2)),
    ]
    return [
        f"## Designs over {rows.experiments} experiments each, at equal time",
        "",
        markdown_table(list(rows.monte_carlo), columns=columns),
        "",
    ]


def _comparison(rows: PaperRows) -> list[str]:
    return ["## Paper | reproduced", "", markdown_table(list(rows.comparison)), ""]


def claim_rows(claims: Sequence[Finding]) -> list[Row]:
    """Findings as rows of a table."""
    return [asdict(f) for f in claims]


def _number(value: Cell) -> str:
    return f"{number_of(value):.3g}"
