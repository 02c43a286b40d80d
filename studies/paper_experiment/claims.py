"""Each claim of the paper, with numbers, intervals and a verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy import stats

from studies.paper_experiment.campaign import FRICTIONS, JOINTS, SETS, ProcessingComparison
from studies.paper_experiment.designs import DesignSet, HorizonTable
from studies.paper_experiment.monte_carlo import MonteCarlo, infeasible
from studies.paper_experiment.values import GENERATIONS, PARAMETERS

LEVEL = 0.95
STATIC_FRICTION = "the static friction of joint 1 depends on the trajectory"
J_K_GA, J_D_GA, J_K_EXACT, J_D_EXACT = range(4)
Verdict = Literal["confirmed", "refuted", "undecided"]


@dataclass(frozen=True)
class Finding:
    """One measured answer to one claim.

    Attributes:
        claim: Short name of the claim.
        statement: What is measured, such that `expected` is the paper's side of zero or one.
        friction: Of the simulated arm.
        processing: Of the signals.
        value: Measured.
        lower: Of its 95 % interval.
        upper: Of its 95 % interval.
        unit: Of the value.
        verdict: On the claim, from the interval alone.
    """

    claim: str
    statement: str
    friction: str
    processing: str
    value: float
    lower: float
    upper: float
    unit: str
    verdict: Verdict


def find_claims(
    table: HorizonTable,
    designs: DesignSet,
    runs: MonteCarlo,
    comparisons: Mapping[tuple[str, str], ProcessingComparison],
    truth: Float[ndarray, "8"],
) -> list[Finding]:
    """All findings, claim by claim."""
    findings: list[Finding] = []
    findings += _generations(designs)
    findings += _more_terms(table)
    findings += _speed(table)
    for f, friction in enumerate(FRICTIONS):
        for r, processing in enumerate(runs.processings.tolist()):
            where = (friction, processing)
            findings += _prediction_error(runs, f, r, where)
            findings += _measured_variance(runs, f, r, where)
            findings += _static_friction(runs, f, r, where)
            findings += _infeasible(runs, f, r, where)
            if friction == "plain":
                findings += _exact_limits(runs, f, r, where, truth)
                findings += _covariance(runs, f, r, where)
    findings += _richer_friction(runs)
    findings += _static_friction_by_processing(comparisons)
    return sorted(findings, key=lambda f: [g.claim for g in findings].index(f.claim))


def _prediction_error(runs: MonteCarlo, f: int, r: int, where: tuple[str, str]) -> list[Finding]:
    found = []
    for s in (1, 2):
        for j in range(JOINTS):
            difference = 100 * (
                runs.relative[f, J_K_GA, r, :, s, j] - runs.relative[f, J_D_GA, r, :, s, j]
            )
            found.append(
                _judged(
                    "J_k-optimal trajectories give the lowest relative prediction error",
                    f"relative error of J_k less J_d, {SETS[s]} set, joint {j + 1}",
                    where,
                    _mean_interval(difference),
                    "%",
                    expected="below",
                )
            )
    return found


def _measured_variance(runs: MonteCarlo, f: int, r: int, where: tuple[str, str]) -> list[Finding]:
    found = []
    for j in range(JOINTS):
        ratio = np.log(runs.variances[f, J_D_GA, r, :, j] / runs.variances[f, J_K_GA, r, :, j])
        interval = tuple(float(np.exp(x)) for x in _mean_interval(ratio))
        found.append(
            _judged(
                "J_d-optimal trajectories are measured with higher variance",
                f"torque variance of J_d over J_k, joint {j + 1}",
                where,
                interval,
                "-",
                expected="above",
                pivot=1.0,
            )
        )
    return found


def _static_friction(runs: MonteCarlo, f: int, r: int, where: tuple[str, str]) -> list[Finding]:
    difference = runs.parameters[f, J_K_GA, r, :, 4] - runs.parameters[f, J_D_GA, r, :, 4]
    return [
        _judged(
            STATIC_FRICTION,
            "gamma_s1 estimated with J_k less that with J_d",
            where,
            _mean_interval(difference),
            "N m",
            expected="away",
        )
    ]


def _static_friction_by_processing(
    processing: Mapping[tuple[str, str], ProcessingComparison],
) -> list[Finding]:
    """The same with every processing, over fewer experiments of their own noise."""
    found = []
    for friction in FRICTIONS:
        pair = [processing[design, friction] for design in ("J_k, GA", "J_d, GA")]
        for w, way in enumerate(pair[0].ways.tolist()):
            first, second = (p.parameters[w, :, 4] for p in pair)
            test = stats.ttest_ind(first, second, equal_var=False)
            interval = test.confidence_interval(LEVEL)
            found.append(
                _judged(
                    STATIC_FRICTION,
                    f"gamma_s1 estimated with J_k less that with J_d, {len(first)} experiments",
                    (friction, way),
                    (float(first.mean() - second.mean()), interval.low, interval.high),
                    "N m",
                    expected="away",
                )
            )
    return found


def _infeasible(runs: MonteCarlo, f: int, r: int, where: tuple[str, str]) -> list[Finding]:
    wrong = infeasible(runs.parameters[f, [J_K_GA, J_D_GA], r]).ravel()
    interval = stats.binomtest(int(wrong.sum()), len(wrong)).proportion_ci(LEVEL, "wilson")
    share = float(wrong.mean())
    verdict: Verdict = "confirmed" if wrong.any() else "undecided"
    return [
        Finding(
            "plain least squares may return infeasible values",
            "share of experiments (both designs) whose estimate no real arm has",
            *where,
            100 * share,
            100 * interval.low,
            100 * interval.high,
            "%",
            verdict,
        )
    ]


def _exact_limits(
    runs: MonteCarlo, f: int, r: int, where: tuple[str, str], truth: Float[ndarray, "8"]
) -> list[Finding]:
    found = []
    for exact, genetic, name in ((J_K_EXACT, J_K_GA, "J_k"), (J_D_EXACT, J_D_GA, "J_d")):
        std = [runs.parameters[f, d, r].std(axis=0, ddof=1) for d in (exact, genetic)]
        logs = np.log(std[0] / std[1])
        # Eight parameters: the geometric mean over them, spread by the F law of each.
        freedom = runs.parameters.shape[3] - 1
        half = 1.96 * np.sqrt(1 / freedom) / np.sqrt(len(logs))
        mean = float(logs.mean())
        interval = tuple(float(np.exp(x)) for x in (mean, mean - half, mean + half))
        found.append(
            _judged(
                "exact limits give better estimates in the same time (not in the paper)",
                f"standard deviation of the parameters, exact-limits {name} over GA {name}",
                where,
                interval,
                "-",
                expected="below",
                pivot=1.0,
            )
        )
        error = [
            np.sqrt((((runs.parameters[f, d, r] - truth) / truth) ** 2).mean(axis=1))
            for d in (exact, genetic)
        ]
        found.append(
            _judged(
                "exact limits give better estimates in the same time (not in the paper)",
                f"rms relative parameter error, bias included, exact-limits {name} less GA {name}",
                where,
                _mean_interval(100 * (error[0] - error[1])),
                "%",
                expected="below",
            )
        )
        for j in range(JOINTS):
            gain = 100 * (
                runs.relative[f, exact, r, :, 2, j] - runs.relative[f, genetic, r, :, 2, j]
            )
            found.append(
                _judged(
                    "exact limits give better torque predictions (not in the paper)",
                    f"relative error on the test set, exact-limits {name} less GA {name}, "
                    f"joint {j + 1}",
                    where,
                    _mean_interval(gain),
                    "%",
                    expected="below",
                )
            )
    return found


def _covariance(runs: MonteCarlo, f: int, r: int, where: tuple[str, str]) -> list[Finding]:
    found = []
    for d, name in ((J_K_GA, "J_k"), (J_D_GA, "J_d")):
        achieved = runs.parameters[f, d, r].var(axis=0, ddof=1)
        predicted = runs.predicted[f, d, r].mean(axis=0)
        freedom = runs.parameters.shape[3] - 1
        quantiles = stats.chi2.ppf([0.5 + LEVEL / 2, 0.5 - LEVEL / 2], freedom) / freedom
        for p, (symbol, _) in enumerate(PARAMETERS):
            ratio = float(achieved[p] / predicted[p])
            lower, upper = (float(ratio / q) for q in quantiles)
            verdict: Verdict = "confirmed" if lower <= 1 <= upper else "refuted"
            found.append(
                Finding(
                    "P of (8) is the covariance of the estimate",
                    f"achieved over predicted variance of {symbol}, {name}",
                    *where,
                    ratio,
                    lower,
                    upper,
                    "-",
                    verdict,
                )
            )
    return found


def _richer_friction(runs: MonteCarlo) -> list[Finding]:
    found = []
    plain, rich = FRICTIONS.index("plain"), FRICTIONS.index("rich")
    for r, processing in enumerate(runs.processings.tolist()):
        for j in range(JOINTS):
            excess = 100 * (
                runs.relative[rich, J_K_GA, r, :, 2, j] - runs.relative[plain, J_K_GA, r, :, 2, j]
            )
            found.append(
                _judged(
                    "a more accurate model of the friction may be useful",
                    f"test error of J_k with rich less with plain friction, joint {j + 1}",
                    ("both", processing),
                    _mean_interval(excess),
                    "%",
                    expected="above",
                )
            )
    return found


def _generations(designs: DesignSet) -> list[Finding]:
    best = designs.best_so_far[0]
    reached = float(np.argmax(best <= 1.05 * best[-1]))
    verdict: Verdict = "confirmed" if reached < GENERATIONS else "refuted"
    statement = "generations of the best J_k run until within 5 % of its end"
    return [
        Finding(
            "the optimum is found in under 20 generations",
            statement,
            "-",
            "-",
            reached,
            reached,
            reached,
            "-",
            verdict,
        )
    ]


def _more_terms(table: HorizonTable) -> list[Finding]:
    found = []
    for k in range(1, len(table.terms)):
        if table.terms[k] < table.terms[0]:
            continue
        gain = np.log(table.J_k_by_terms[k] / table.J_k_by_terms[0])
        value, lower, upper = (float(np.exp(x)) for x in _mean_interval(gain))
        verdict: Verdict = "refuted" if upper < 1 else "confirmed" if lower > 1 else "undecided"
        found.append(
            Finding(
                "more than three sines give no significant improvement",
                f"J_k with W = {table.terms[k]} over W = {table.terms[0]}, same generations",
                "-",
                "-",
                value,
                lower,
                upper,
                "-",
                verdict,
            )
        )
    return found


def _speed(table: HorizonTable) -> list[Finding]:
    chosen = int(np.argmin(np.abs(table.horizon - table.chosen)))
    ratio = np.log(table.speed[1, chosen] / table.speed[0, chosen])
    found = []
    for j in range(JOINTS):
        interval = tuple(float(np.exp(x)) for x in _mean_interval(ratio[:, j]))
        found.append(
            _judged(
                "J_d-optimal trajectories move faster",
                f"rms speed of J_d over J_k, joint {j + 1}, over seeds of the algorithm",
                ("-", "-"),
                interval,
                "-",
                expected="above",
                pivot=1.0,
            )
        )
    return found


def _judged(
    claim: str,
    statement: str,
    where: tuple[str, str],
    interval: tuple[float, ...],
    unit: str,
    *,
    expected: Literal["below", "above", "away"],
    pivot: float = 0.0,
) -> Finding:
    value, lower, upper = interval
    is_below, is_above = upper < pivot, lower > pivot
    right = {"below": is_below, "above": is_above, "away": is_below or is_above}[expected]
    wrong = {"below": is_above, "above": is_below, "away": False}[expected]
    verdict: Verdict = "confirmed" if right else "refuted" if wrong else "undecided"
    return Finding(claim, statement, *where, value, lower, upper, unit, verdict)


def _mean_interval(x: Float[ndarray, " experiments"]) -> tuple[float, float, float]:
    """Mean and its 95 % interval by Student's law."""
    mean = float(x.mean())
    half = float(stats.t.ppf(0.5 + LEVEL / 2, len(x) - 1) * x.std(ddof=1) / np.sqrt(len(x)))
    return mean, mean - half, mean + half
