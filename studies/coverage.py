"""Do 95 % intervals hold the truth in 95 % of estimates, with white and with coloured noise?

Simulated torques of the paper's two-link arm, (16), on random harmonic motion (10); each run
draws a motion and a noise, estimates, and asks of each interval whether it holds the truth.

    python -m studies.coverage [--workers N] [--scheduler ADDRESS] [--smoke]
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import ClassVar

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy import stats
from scipy.signal import butter, lfilter, sosfilt

from oed.commands.options import parse
from oed.dynamics.motion import Motion
from oed.dynamics.planar import planar_regressor
from oed.estimation.covariance import CovarianceMethod, estimate_covariance
from oed.estimation.least_squares import batch_least_squares
from oed.estimation.noise import whiten
from oed.estimation.triangular import Solution
from oed.estimation.weights import variances_from_residuals
from oed.process_end import RESUMES, leave
from oed.report.table import markdown_table, parse_cell
from oed.robot.builtin import (
    IMI_BASE_PARAMETERS,
    IMI_COULOMB,
    IMI_LINK_LENGTHS,
    IMI_VISCOUS,
)
from studies.case_runner import CaseRunner, Outcome, RowFile, leave_page, work_through
from studies.study_options import CaseOptions

KEY = ("samples", "recordings", "noise", "colour", "method")
VALUES = (
    "runs", "coverage", "coverage_error", "least", "greatest", "median_half_width_Izz_1",
    "milliseconds", "status",
)  # fmt: skip
TRUTH = np.array(
    [*IMI_BASE_PARAMETERS, IMI_COULOMB[0], IMI_VISCOUS[0], IMI_COULOMB[1], IMI_VISCOUS[1]]
)
LARGEST_FREQUENCY = 1.825  # [rad/s], Calafiore 2001, section 4
BURN_IN = 2000  # [samples] before the noise is taken for stationary


@dataclass(frozen=True)
class Noise:
    """A torque noise of unit variance.

    Attributes:
        kind: "white", "ar1" or "lowpass".
        colour: Coefficient of the AR(1), or cut-off per Nyquist frequency of the fourth-order
            Butterworth low-pass.
    """

    kind: str
    colour: float = 0.0

    def draw(self, rng: np.random.Generator, samples: int) -> Float[ndarray, "samples 2"]:
        """One stationary record of both joints."""
        innovation = rng.standard_normal((samples + BURN_IN, 2))
        if self.kind == "ar1":
            scale = np.sqrt(1 - self.colour**2)
            innovation = np.asarray(lfilter([scale], [1.0, -self.colour], innovation, axis=0))
        elif self.kind == "lowpass":
            sections = butter(4, self.colour, output="sos")
            innovation = np.asarray(sosfilt(sections, innovation, axis=0)) / np.sqrt(self.colour)
        return innovation[BURN_IN:]


@dataclass(frozen=True)
class Config:
    """What is simulated.

    Attributes:
        runs: Estimates of each case.
        stacks: Total samples N, and how many recordings of equal length they come from.
        sample_time: [s].
        deviations: Standard deviation of the noise of each joint [N m].
        noises: Colours of the noise.
        methods: Of the covariance.
        level: Of the intervals.
        seed: Of everything random.
    """

    runs: int = 1000
    stacks: tuple[tuple[int, int], ...] = ((480, 1),)
    sample_time: float = 0.02
    deviations: tuple[float, float] = (1.2, 0.3)
    noises: tuple[Noise, ...] = (
        Noise("white"),
        Noise("ar1", 0.5),
        Noise("ar1", 0.8),
        Noise("ar1", 0.95),
        Noise("lowpass", 0.5),
        Noise("lowpass", 0.2),
    )
    methods: tuple[CovarianceMethod, ...] = ("white", "newey_west", "prewhitened", "hac")
    level: float = 0.95
    seed: int = 20010218


SMOKE = Config(runs=3, stacks=((240, 1),), noises=(Noise("white"), Noise("ar1", 0.8)))


@dataclass(frozen=True)
class Condition:
    """What estimates are made from.

    Attributes:
        config: Of the study.
        place: Among all conditions: with the study's seed it decides what is drawn.
        samples: Total N.
        recordings: Of equal length, that they come from.
        noise: Of the torque.
    """

    config: Config
    place: int
    samples: int
    recordings: int
    noise: Noise

    @property
    def segments(self) -> tuple[int, ...]:
        """Samples of each recording."""
        return (self.samples // self.recordings,) * self.recordings


@dataclass(frozen=True)
class Case:
    """A covariance method under a condition."""

    condition: Condition
    method: CovarianceMethod

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        one = self.condition
        stack = (str(one.samples), str(one.recordings))
        return (*stack, one.noise.kind, str(one.noise.colour), self.method)


def cases_of(config: Config) -> list[Case]:
    """All methods of a condition together, so that its estimates are made once."""
    choices = [(*stack, noise) for stack in config.stacks for noise in config.noises]
    return [
        Case(Condition(config, place, *choice), method)
        for place, choice in enumerate(choices)
        for method in config.methods
    ]


@lru_cache(maxsize=1)
def simulate(one: Condition) -> list[tuple[ndarray, ndarray, Solution]]:
    """Whitened regressor (N n, 8) and residual (N, n) of each run, and the estimate."""
    config, found = one.config, []
    rng = np.random.default_rng(np.random.SeedSequence(config.seed, spawn_key=(one.place,)))
    for _ in range(config.runs):
        W = np.concatenate([random_regressor(rng, n, config.sample_time) for n in one.segments])
        v = np.concatenate([one.noise.draw(rng, n) for n in one.segments])
        y = W @ TRUTH + (v * config.deviations).reshape(-1)
        variances = variances_from_residuals(W, y, 2)
        solution = batch_least_squares(W, y, 2, noise=variances)
        residual = whiten(y - W @ solution.parameters, variances, 2).reshape(-1, 2)
        found.append((whiten(W, variances, 2), residual, solution))
    return found


def work(case: Case) -> Outcome:
    """How often a method's intervals hold the truth."""
    config, one = case.condition.config, case.condition
    hits, widths, seconds = [], [], 0.0
    for W, residual, found in simulate(one):
        start = time.perf_counter()
        spread = estimate_covariance(
            W, residual, found.posterior_factor, method=case.method, segments=one.segments
        )
        seconds += time.perf_counter() - start
        quantile = stats.t.ppf(0.5 + config.level / 2, spread.degrees_of_freedom)
        reach = quantile * np.sqrt(np.diag(spread.covariance))
        hits.append(np.abs(found.parameters - TRUTH) <= reach)
        widths.append(reach)
    by_parameter = np.mean(hits, axis=0)
    return {
        "runs": config.runs,
        "coverage": float(by_parameter.mean()),
        "coverage_error": float(np.mean(hits, axis=1).std() / np.sqrt(config.runs)),
        "least": float(by_parameter.min()),
        "greatest": float(by_parameter.max()),
        "median_half_width_Izz_1": float(np.median(np.array(widths)[:, 0])),
        "milliseconds": 1e3 * seconds / config.runs,
        "status": "done",
    }


def random_regressor(
    rng: np.random.Generator, samples: int, sample_time: float
) -> Float[ndarray, "rows 8"]:
    """The regressor (16) on a motion of the harmonic class (10) with three terms a joint."""
    amplitude = rng.uniform(-0.5, 0.5, (3, 2))  # [rad], (12c) for q_max = 1.5 rad
    omega = rng.uniform(0.2, 1.0, (3, 2)) * LARGEST_FREQUENCY
    t = np.arange(samples) * sample_time
    phase = t[:, None, None] * omega
    motion = Motion(
        t=t,
        q=np.sum(amplitude * np.sin(phase), axis=1),
        dq=np.sum(amplitude * omega * np.cos(phase), axis=1),
        ddq=np.sum(-amplitude * omega**2 * np.sin(phase), axis=1),
    )
    return planar_regressor(motion, IMI_LINK_LENGTHS[0]).reshape(2 * samples, 8)


def summarise(rows: Sequence[Mapping[str, str]], config: Config) -> str:
    """The rows as a page."""
    columns = ["samples", "recordings", "noise", "colour", "method", "coverage", "least"]
    shown = [{c: parse_cell(row[c]) for c in columns} for row in rows]
    return (
        f"# Coverage of {100 * config.level:g} % intervals\n\n"
        f"{config.runs} simulated estimates a row; two-link arm (16), random harmonic motion, "
        f"one sample every {config.sample_time:g} s. `coverage` is the share of intervals that "
        "hold the truth, over all eight parameters; `least` that of the parameter covered worst. "
        "`colour` is the coefficient of the AR(1), or the cut-off per Nyquist frequency of the "
        "low-pass.\n\n" + markdown_table(shown, digits=3)
    )


@dataclass(frozen=True)
class Options(CaseOptions):
    """Do 95 % intervals hold the truth in 95 % of estimates, with white and with coloured noise?"""

    study: ClassVar[str] = "coverage"
    names: ClassVar[tuple[str, ...]] = ("summary.md", "provenance.json")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 1 if all failed, else 0."""
    options = parse(Options, prog="python -m studies.coverage", arguments=arguments)
    config = SMOKE if options.smoke else Config()
    rows, cases = RowFile(options.results / "runs.csv", KEY, VALUES), cases_of(config)

    def write(out: Path) -> None:
        text = summarise(rows.rows_of(case.key for case in cases), config)
        leave_page(text, config, config.seed, out)

    return work_through(CaseRunner(work, rows, "coverage"), cases, options, config, write)


if __name__ == "__main__":
    leave(main, "studies.coverage", RESUMES)
