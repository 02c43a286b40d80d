"""What is claimed, what would confirm it and what would refute it, written before it is run.

A claim holds if its quantity lies in a band; how far the band's end is from no effect at all is
the size that matters, with its reason. It is confirmed if the whole 95 % interval lies within the
band, refuted if the whole interval lies outside, and else what was done does not tell.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Literal

from studies.paper_experiment.random_effects import Interval

Verdict = Literal["confirmed", "refuted", "not told apart"]


@dataclass(frozen=True)
class Claim:
    """One claim.

    Attributes:
        statement: In the paper's sense.
        quantity: What is measured.
        unit: Of the quantity; "ratio" for one whose logarithm is averaged.
        low: Lower end of the values that the claim says.
        high: Upper end.
        reason: Why the band ends there.
        is_own: Whether this project claims it, not the paper.
    """

    statement: str
    quantity: str
    unit: str
    reason: str
    low: float = -inf
    high: float = inf
    is_own: bool = False

    @property
    def band(self) -> str:
        """Where the whole interval must lie to confirm."""
        if self.low > -inf and self.high < inf:
            return f"{self.low:g} to {self.high:g}{self._unit}"
        return f"above {self.low:g}{self._unit}" if self.low > -inf else self._below(self.high)

    @property
    def outside(self) -> str:
        """Where the whole interval must lie to refute."""
        above = f"above {self.high:g}{self._unit}" if self.high < inf else ""
        below = self._below(self.low) if self.low > -inf else ""
        return " or ".join(filter(None, (below, above)))

    @property
    def _unit(self) -> str:
        return f" {self.unit}" if self.unit not in ("", "ratio") else ""

    def _below(self, end: float) -> str:
        return f"below {end:g}{self._unit}"

    def verdict(self, interval: Interval) -> Verdict:
        """What an interval says of the claim."""
        if self.low < interval.lower and interval.upper < self.high:
            return "confirmed"
        if interval.upper <= self.low or self.high <= interval.lower:
            return "refuted"
        return "not told apart"


GENERATIONS = Claim(
    "the optimum is found in under 20 generations",
    "runs that are within 5 % of their own end before generation 20",
    "%",
    "the paper reports one run: most have to do it",
    low=50,
)
TERMS = Claim(
    "more than three sines a joint give no significant improvement",
    "J_k with five over J_k with three sines, after as many generations",
    "ratio",
    "5 % of J_k change a standard deviation by 2 %",
    low=0.95,
)
DETERMINANT = Claim(
    "the best J_d is 17.9",
    "J_d that runs end at, less the paper's, at the horizon whose J_k is the paper's",
    "",
    "0.33 is a tenth of every one of the eight parameters' information",
    low=-0.33,
    high=0.33,
)
SPEED = Claim(
    "J_d-optimal trajectories move faster",
    "rms speed of J_d over that of J_k designs",
    "ratio",
    "the paper's measured torques, which grow with speed, differ by 1.26 at joint 2, 1.64 at joint 1",
    low=1.25,
)
VALIDATION = Claim(
    "J_k-optimal trajectories give the lowest relative error on their own validation set",
    "relative error on the validation set, J_k less J_d designs",
    "%",
    "the paper's own differences are 0.8 and 10 %",
    high=-0.8,
)
PREDICTION = Claim(
    "J_k-optimal trajectories give the lowest relative error on a test trajectory",
    "relative error on test motions, J_k less J_d designs",
    "%",
    "a quarter of the paper's smaller difference, which is 4.4 %",
    high=-1.1,
)
VARIANCE = Claim(
    "J_d-optimal trajectories are measured with higher variance",
    "torque variance between repetitions, J_d over J_k designs",
    "ratio",
    "the paper's ratios are 37 and 2.5",
    low=2,
)
STATIC_FRICTION = Claim(
    "static friction of joint 1 is estimated higher on J_k- than on J_d-optimal trajectories",
    "gamma_s1 estimated on J_k less that on J_d designs",
    "N m",
    "half of the paper's difference, which is 2.11 N m",
    low=1.05,
)
INFEASIBLE = Claim(
    "plain least squares may return physically infeasible values",
    "experiments whose estimate no real arm has",
    "%",
    "one in a hundred is met in practice",
    low=1,
)
FRICTION = Claim(
    "a more accurate friction model is useful",
    "relative error on test motions, estimate with richer friction less the paper's, same data",
    "%",
    "a tenth of the errors that the paper reports, 12 to 24 %",
    high=-1.5,
)
ENERGY = Claim(
    "the energy-based model serves equally well",
    "rms relative error of the parameters, energy over torque model, same data",
    "ratio",
    "a quarter more error is paid by half as much again of measuring time",
    high=1.25,
)
COVARIANCE = Claim(
    "P of (8) is the covariance of the estimate",
    "spread of estimates over what P says, rms over all eight parameters",
    "ratio",
    "a quarter off, 95 % intervals hold 88 to 99 %",
    low=0.8,
    high=1.25,
)
EXACT_ERROR = Claim(
    "designs under the limits themselves, not the paper's (12), give better estimates",
    "rms relative error of the parameters, exact limits over the genetic algorithm's",
    "ratio",
    "a tenth less error saves a fifth of measuring time",
    high=0.9,
    is_own=True,
)
EXACT_PREDICTION = Claim(
    "designs under the limits themselves give better predictions",
    "relative error on test motions, exact limits less the genetic algorithm's",
    "%",
    "as for J_k against J_d",
    high=-1.1,
    is_own=True,
)
CLAIMS = (
    GENERATIONS,
    TERMS,
    DETERMINANT,
    SPEED,
    VALIDATION,
    PREDICTION,
    VARIANCE,
    STATIC_FRICTION,
    INFEASIBLE,
    FRICTION,
    ENERGY,
    COVARIANCE,
    EXACT_ERROR,
    EXACT_PREDICTION,
)
