"""results/paper/summary.md, in plain words made from the measured rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oed.report.table import Cell, Row, markdown_table, number_of
from studies.paper_experiment import values as paper
from studies.paper_experiment.claims import CLAIMS, PREDICTION, Claim
from studies.paper_experiment.config import Config
from studies.paper_experiment.findings import Finding

SOURCES = ("std, design pair", "std, test motion", "std, pair and motion", "std, noise")


@dataclass(frozen=True)
class PaperRows:
    """All tables of the study, their numbers rounded, and the findings behind `claims`."""

    comparison: Sequence[Row]
    horizons: Sequence[Row]
    cells: Sequence[Row]
    claims: Sequence[Row]
    drake: Sequence[Row]
    findings: Sequence[Finding]
    horizon: float
    config: Config


def summarise(rows: PaperRows) -> str:
    """The summary as Markdown."""
    parts = (_head, _five_sentences, _claims, _sources, _designs, _cells, _comparison)
    return "\n".join(line for part in parts for line in part(rows))


def _head(rows: PaperRows) -> list[str]:
    sizes, drake = rows.config.designs, rows.drake[0]
    return [
        "# The paper's experiment, in simulation",
        "",
        (
            "The IMI arm cannot be had. It is simulated with the parameters that the paper estimated on its "
            "J_k-optimal trajectory as the truth, the paper's observer, sampling and filter, gains designed "
            "for its specification, resolvers, and a torque disturbance whose level is calibrated so that the "
            'variances over 20 repetitions of a J_k trajectory are the paper\'s. "Plain" friction is the '
            'paper\'s Coulomb and viscous law; "rich" adds what its authors suspected: a rise towards '
            "standstill, presliding, thinning viscous friction and motor ripple. How rich is our choice, "
            "not a measurement."
        ),
        "",
        (
            f"Drawn and crossed: {sizes.pairs} pairs of designs, each pair from seeds of their own of the "
            f"genetic algorithm, {sizes.tests} test motions, {rows.config.draws} draws of the noise on each. "
            "No design is chosen by its value. Intervals hold 95 % over designs, test motions and noise."
        ),
        "",
        (
            "The arm is a Drake MultibodyPlant in a Diagram; the experiments below run on a compiled loop of "
            f"the same equations, which differs from Drake by at most {_number(drake['position'])} rad and "
            f"{_number(drake['command'])} N m over {_number(drake['duration'])} s."
        ),
        "",
    ]


def _five_sentences(rows: PaperRows) -> list[str]:
    words = {claim: overall(_of(claim, rows)) for claim in CLAIMS if not claim.is_own}

    def listed(*wanted: str) -> str:
        names = [claim.statement for claim, word in words.items() if word in wanted]
        return "; ".join(names) or "none"

    return [
        "## What the paper got right, in five sentences",
        "",
        f"1. Confirmed, of the paper's {len(words)} claims: {listed('confirmed')}.",
        f"2. Refuted: {listed('refuted')}.",
        (
            "3. Neither, because it depends on joint, friction or signals, or is not told apart: "
            f"{listed('it depends', 'confirmed in part', 'refuted in part', 'not told apart')}."
        ),
        f"4. {_prediction_sentence(rows)}",
        f"5. {_range_sentence(rows)}",
        "",
    ]


def _prediction_sentence(rows: PaperRows) -> str:
    sources = [f.sources for f in _of(PREDICTION, rows) if f.sources is not None]
    variances = np.mean(
        [[x**2 for x in (s.pair, s.motion, s.both, s.noise)] for s in sources], axis=0
    )
    pair, motion, both, noise = 100 * variances / variances.sum()
    return (
        "Which criterion's design predicts a test motion better differs from experiment to experiment "
        f"by which pair of designs it is ({pair:.0f} % of the variance), which test motion "
        f"({motion:.0f} %), which of both together ({both:.0f} %) and by noise ({noise:.0f} %): one "
        "experiment of each, as the paper's, "
        + ("says little of the criteria." if noise < 50 else "is limited by its noise.")
    )


def _range_sentence(rows: PaperRows) -> str:
    measured = [r for r in rows.comparison if r["design"] != "-" and r["from"] != r["to"]]
    inside = [
        r for r in measured if number_of(r["from"]) <= number_of(r["paper"]) <= number_of(r["to"])
    ]
    far = max(
        (r for r in measured if number_of(r["paper"]) > 0 and number_of(r["mean of ours"]) > 0),
        key=lambda r: abs(np.log(number_of(r["paper"]) / number_of(r["mean of ours"]))),
    )
    return (
        f"Of the {len(measured)} numbers that the paper gives of its designs and experiments, "
        f"{len(inside)} lie where 95 % of ours do; farthest off is {far['quantity']} of {far['design']} "
        f"({_number(far['paper'])} {far['unit']} in the paper, {_number(far['from'])} to "
        f"{_number(far['to'])} here)."
    )


def _claims(rows: PaperRows) -> list[str]:
    lines = [
        "## Claims",
        "",
        (
            "What would confirm and what would refute each was written before the study ran "
            "(`studies/paper_experiment/claims.py`). What neither confirms nor refutes is not told apart."
        ),
        "",
    ]
    for claim in CLAIMS:
        findings = _of(claim, rows)
        own = " (not in the paper)" if claim.is_own else ""
        counts = {v: sum(f.verdict == v for f in findings) for v in _VERDICTS}
        counted = ", ".join(f"{count} {verdict}" for verdict, count in counts.items() if count)
        lines += [
            f"### {claim.statement[0].upper()}{claim.statement[1:]}{own}: {overall(findings)}",
            "",
            (
                f"Measured: {claim.quantity}. Confirmed {claim.band}, refuted {claim.outside}, by the whole "
                f"interval: {claim.reason}. {len(findings)} measured: {counted}."
            ),
            "",
            markdown_table(
                [r for r in rows.claims if r["claim"] == claim.statement],
                columns=("friction", "signals", "detail", "value", "lower", "upper", "verdict"),
                digits=3,
            ),
            "",
        ]
    return lines


_VERDICTS = ("confirmed", "refuted", "not told apart")


def overall(findings: Sequence[Finding]) -> str:
    """One word for several findings on one claim."""
    verdicts = {f.verdict for f in findings}
    if len(verdicts) == 1:
        return verdicts.pop()
    if {"confirmed", "refuted"} <= verdicts:
        return "it depends"
    return "confirmed in part" if "confirmed" in verdicts else "refuted in part"


def _sources(rows: PaperRows) -> list[str]:
    drawn = [r for r in rows.claims if r["std, noise"] is not None]
    names = dict.fromkeys(str(r["quantity"]) for r in drawn)
    lines = [
        "## Where the spread is from",
        "",
        (
            "Standard deviation of a single experiment by source, averaged over what is measured of a "
            "quantity; in per cent for a ratio. The same for each in `claims.csv`."
        ),
        "",
    ]
    table: list[Row] = []
    for name in names:
        mine = [r for r in drawn if r["quantity"] == name]
        unit = "%" if mine[0]["unit"] == "ratio" else mine[0]["unit"]
        means = {
            source: float(np.sqrt(np.mean([number_of(r[source]) ** 2 for r in mine])))
            for source in SOURCES
        }
        table.append({"quantity": name, "unit": unit, **means})
    return [*lines, markdown_table(table, digits=2), ""]


def _designs(rows: PaperRows) -> list[str]:
    is_last = rows.horizon == max(rows.config.designs.horizons)
    return [
        "## Designs, and the horizon that the paper does not state",
        "",
        (
            "J_k is cond(Lambda); J_d is log10 det(Lambda) at "
            f"{rows.config.designs.samples} instants and two joints, and grows with their number: compare "
            f"its column at half the instants. The horizon used, {_number(rows.horizon)} s, is the one whose "
            f"median J_k is nearest to the paper's {paper.J_K}"
            + (": the longest that was tried." if is_last else ".")
        ),
        "",
        markdown_table(list(rows.horizons)),
        "",
    ]


def _cells(rows: PaperRows) -> list[str]:
    return [
        "## What friction, designs and the processing of the signals do",
        "",
        (
            '"online" is the paper to the letter, "aligned" filters the position too, "zero_phase" is '
            'what the authors wanted, "parallel" filters the regressor\'s columns like the torque. Bias is '
            "that of the mean over the noise, std the spread around it, both rms over parameters relative to "
            'the truth; residual and noise are of the estimation set, noise between repetitions; "richer" '
            "is the estimate whose friction has two more terms a joint."
        ),
        "",
        markdown_table(list(rows.cells), digits=3),
        "",
    ]


def _comparison(rows: PaperRows) -> list[str]:
    return [
        "## Paper | reproduced",
        "",
        "From and to hold 95 % of single experiments with rich friction and the paper's signals.",
        "",
        markdown_table(list(rows.comparison)),
        "",
        (
            f"- The paper's own residuals ({paper.RMS[0][0][0]} and {paper.RMS[0][0][1]} N m) are smaller "
            f"than the standard deviations it measured ({paper.VARIANCES[0][0] ** 0.5:.2f} and "
            f"{paper.VARIANCES[0][1] ** 0.5:.2f} N m). This is consistent only if the variance was taken "
            "before the filter, or drifts over the 20 repetitions; here it is taken before the filter."
        ),
        (
            f"- The paper measured a variance of {paper.VARIANCES[1][0]} N^2 m^2 at joint 1 of its J_d "
            f"trajectory, {_share():.0f} % of its mean squared torque; a disturbance that does not depend on "
            "the motion, as here, gives both trajectories the same variance."
        ),
        "",
    ]


def _share() -> float:
    return 100 * paper.VARIANCES[1][0] / (paper.RMS[1][0][0] / paper.RELATIVE[1][0][0]) ** 2


def _of(claim: Claim, rows: PaperRows) -> list[Finding]:
    return [f for f in rows.findings if f.claim == claim]


def _number(value: Cell) -> str:
    return f"{number_of(value):.3g}"
