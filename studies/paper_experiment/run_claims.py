"""What the paper claims of experiments, held against hundreds of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy import stats

from studies.paper_experiment.campaign import FRICTIONS, JOINTS, SETS, ProcessingComparison
from studies.paper_experiment.finding import (
    LEVEL,
    Finding,
    Verdict,
    judged,
    mean_interval,
    ratio_interval,
)
from studies.paper_experiment.monte_carlo import MonteCarlo, infeasible
from studies.paper_experiment.values import PARAMETERS

STATIC_FRICTION = "the static friction of joint 1 depends on the trajectory"
GAMMA_S1 = [symbol for symbol, _ in PARAMETERS].index("gamma_s1")
TEST = SETS.index("test")
J_K_GA, J_D_GA, J_K_EXACT, J_D_EXACT = range(4)


@dataclass(frozen=True)
class Runs:
    """The experiments with one friction of the arm and one processing of the signals.

    Attributes:
        where: Friction and processing.
        parameters: (D, E, 8) of every design and experiment.
        predicted: (D, E, 8) diagonal of P (8).
        variances: (D, E, n) by the paper's formula [N^2 m^2].
        relative: (D, E, 3, n) relative error on the sets of `SETS`.
    """

    where: tuple[str, str]
    parameters: Float[ndarray, "D E 8"]
    predicted: Float[ndarray, "D E 8"]
    variances: Float[ndarray, "D E n"]
    relative: Float[ndarray, "D E 3 n"]

    @classmethod
    def of(cls, monte_carlo: MonteCarlo, friction: str, processing: str) -> Runs:
        """One friction and processing of all."""
        own = (
            FRICTIONS.index(friction),
            slice(None),
            monte_carlo.processings.tolist().index(processing),
        )
        return cls(
            (friction, processing),
            monte_carlo.parameters[own],
            monte_carlo.predicted[own],
            monte_carlo.variances[own],
            monte_carlo.relative[own],
        )


def prediction_error(runs: Runs) -> list[Finding]:
    """On validation and test set, of both criteria."""
    return [
        judged(
            "J_k-optimal trajectories give the lowest relative prediction error",
            f"relative error of J_k less J_d, {SETS[s]} set, joint {j + 1}",
            runs.where,
            mean_interval(100 * (runs.relative[J_K_GA, :, s, j] - runs.relative[J_D_GA, :, s, j])),
            "%",
            expected="below",
        )
        for s in (1, 2)
        for j in range(JOINTS)
    ]


def measured_variance(runs: Runs) -> list[Finding]:
    """Of the torque between repetitions, of both criteria."""
    ratio = np.log(runs.variances[J_D_GA] / runs.variances[J_K_GA])
    return [
        judged(
            "J_d-optimal trajectories are measured with higher variance",
            f"torque variance of J_d over J_k, joint {j + 1}",
            runs.where,
            ratio_interval(ratio[:, j]),
            "-",
            expected="above",
            pivot=1.0,
        )
        for j in range(JOINTS)
    ]


def static_friction(runs: Runs) -> list[Finding]:
    """Of joint 1, estimated on the designs of both criteria."""
    difference = runs.parameters[J_K_GA, :, GAMMA_S1] - runs.parameters[J_D_GA, :, GAMMA_S1]
    return [
        judged(
            STATIC_FRICTION,
            "gamma_s1 estimated with J_k less that with J_d",
            runs.where,
            mean_interval(difference),
            "N m",
            expected="away",
        )
    ]


def static_friction_by_processing(
    processing: Mapping[tuple[str, str], ProcessingComparison],
) -> list[Finding]:
    """The same with every processing, over fewer experiments of their own noise."""
    found = []
    for friction in FRICTIONS:
        pair = [processing[design, friction] for design in ("J_k, GA", "J_d, GA")]
        for w, way in enumerate(pair[0].ways.tolist()):
            first, second = (p.parameters[w, :, GAMMA_S1] for p in pair)
            test = stats.ttest_ind(first, second, equal_var=False)
            interval = test.confidence_interval(LEVEL)
            found.append(
                judged(
                    STATIC_FRICTION,
                    f"gamma_s1 estimated with J_k less that with J_d, {len(first)} experiments",
                    (friction, way),
                    (float(first.mean() - second.mean()), interval.low, interval.high),
                    "N m",
                    expected="away",
                )
            )
    return found


def infeasible_estimates(runs: Runs) -> list[Finding]:
    """How many estimates no real arm has."""
    wrong = infeasible(runs.parameters[[J_K_GA, J_D_GA]]).ravel()
    interval = stats.binomtest(int(wrong.sum()), len(wrong)).proportion_ci(LEVEL, "wilson")
    verdict: Verdict = "confirmed" if wrong.any() else "undecided"
    return [
        Finding(
            "plain least squares may return infeasible values",
            "share of experiments (both designs) whose estimate no real arm has",
            *runs.where,
            100 * float(wrong.mean()),
            100 * interval.low,
            100 * interval.high,
            "%",
            verdict,
        )
    ]


def exact_limits(runs: Runs, truth: Float[ndarray, "8"]) -> list[Finding]:
    """Designs under exact limits against the paper's, criterion by criterion."""
    found = []
    for exact, genetic, name in ((J_K_EXACT, J_K_GA, "J_k"), (J_D_EXACT, J_D_GA, "J_d")):
        found += [_spread(runs, exact, genetic, name), _error(runs, exact, genetic, name, truth)]
        found += _test_errors(runs, exact, genetic, name)
    return found


def _spread(runs: Runs, exact: int, genetic: int, name: str) -> Finding:
    std = [runs.parameters[d].std(axis=0, ddof=1) for d in (exact, genetic)]
    logs = np.log(std[0] / std[1])
    # Eight parameters: the geometric mean over them, spread by the F law of each.
    half = 1.96 * np.sqrt(1 / (runs.parameters.shape[1] - 1)) / np.sqrt(len(logs))
    mean = float(logs.mean())
    return judged(
        "exact limits give better estimates in the same time (not in the paper)",
        f"standard deviation of the parameters, exact-limits {name} over GA {name}",
        runs.where,
        (float(np.exp(mean)), float(np.exp(mean - half)), float(np.exp(mean + half))),
        "-",
        expected="below",
        pivot=1.0,
    )


def _error(runs: Runs, exact: int, genetic: int, name: str, truth: Float[ndarray, "8"]) -> Finding:
    relative = (runs.parameters - truth) / truth
    error = [np.sqrt((relative[d] ** 2).mean(axis=1)) for d in (exact, genetic)]
    return judged(
        "exact limits give better estimates in the same time (not in the paper)",
        f"rms relative parameter error, bias included, exact-limits {name} less GA {name}",
        runs.where,
        mean_interval(100 * (error[0] - error[1])),
        "%",
        expected="below",
    )


def _test_errors(runs: Runs, exact: int, genetic: int, name: str) -> list[Finding]:
    return [
        judged(
            "exact limits give better torque predictions (not in the paper)",
            f"relative error on the test set, exact-limits {name} less GA {name}, joint {j + 1}",
            runs.where,
            mean_interval(
                100 * (runs.relative[exact, :, TEST, j] - runs.relative[genetic, :, TEST, j])
            ),
            "%",
            expected="below",
        )
        for j in range(JOINTS)
    ]


def covariance(runs: Runs) -> list[Finding]:
    """What P of (8) says of the estimate, against what many estimates do."""
    found = []
    freedom = runs.parameters.shape[1] - 1
    quantiles = stats.chi2.ppf([0.5 + LEVEL / 2, 0.5 - LEVEL / 2], freedom) / freedom
    for d, name in ((J_K_GA, "J_k"), (J_D_GA, "J_d")):
        achieved = runs.parameters[d].var(axis=0, ddof=1)
        predicted = runs.predicted[d].mean(axis=0)
        for p, (symbol, _) in enumerate(PARAMETERS):
            ratio = float(achieved[p] / predicted[p])
            lower, upper = (float(ratio / q) for q in quantiles)
            verdict: Verdict = "confirmed" if lower <= 1 <= upper else "refuted"
            found.append(
                Finding(
                    "P of (8) is the covariance of the estimate",
                    f"achieved over predicted variance of {symbol}, {name}",
                    *runs.where,
                    ratio,
                    lower,
                    upper,
                    "-",
                    verdict,
                )
            )
    return found


def richer_friction(plain: Runs, rich: Runs) -> list[Finding]:
    """What the model's friction, which is plain, costs on an arm whose own is rich."""
    _, processing = rich.where
    return [
        judged(
            "a more accurate model of the friction may be useful",
            f"test error of J_k with rich less with plain friction, joint {j + 1}",
            ("both", processing),
            mean_interval(
                100 * (rich.relative[J_K_GA, :, TEST, j] - plain.relative[J_K_GA, :, TEST, j])
            ),
            "%",
            expected="above",
        )
        for j in range(JOINTS)
    ]
