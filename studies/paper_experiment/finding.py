"""One measured answer to one claim, and the verdict that its interval gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy import stats

LEVEL = 0.95
Verdict = Literal["confirmed", "refuted", "undecided"]
Interval = tuple[float, float, float]  # value, lower and upper end
NOWHERE = ("-", "-")  # of a finding on designs alone, that no arm has moved along


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


def judged(
    claim: str,
    statement: str,
    where: tuple[str, str],
    interval: Interval,
    unit: str,
    *,
    expected: Literal["below", "above", "away"],
    pivot: float = 0.0,
) -> Finding:
    """A finding whose interval lies on the paper's side of `pivot`, on the other, or on both.

    Args:
        claim: Short name of the claim.
        statement: What is measured.
        where: Friction and processing.
        interval: Of the measured value.
        unit: Of the value.
        expected: The paper's side; "away" for either, which nothing refutes.
        pivot: Zero for differences, one for ratios.
    """
    value, lower, upper = interval
    is_below, is_above = upper < pivot, lower > pivot
    right = {"below": is_below, "above": is_above, "away": is_below or is_above}[expected]
    wrong = {"below": is_above, "above": is_below, "away": False}[expected]
    verdict: Verdict = "confirmed" if right else "refuted" if wrong else "undecided"
    return Finding(claim, statement, *where, value, lower, upper, unit, verdict)


def mean_interval(x: Float[ndarray, " experiments"]) -> Interval:
    """Mean and its 95 % interval by Student's law."""
    mean = float(x.mean())
    half = float(stats.t.ppf(0.5 + LEVEL / 2, len(x) - 1) * x.std(ddof=1) / np.sqrt(len(x)))
    return mean, mean - half, mean + half


def ratio_interval(logs: Float[ndarray, " experiments"]) -> Interval:
    """Geometric mean of ratios and its 95 % interval, from the ratios' logarithms."""
    value, lower, upper = (float(np.exp(x)) for x in mean_interval(logs))
    return value, lower, upper
