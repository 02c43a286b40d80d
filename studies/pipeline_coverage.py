"""Do the intervals that `oed identify` prints hold the truth, through its whole pipeline?

    python -m studies.pipeline_coverage [--experiments N] [--workers N] [--scheduler ADDRESS] [--smoke]

A fixed motion of a UR5 or a Panda with hard sign friction is logged again and again. Each log has noise of
its own and 17-bit encoders; it is identified as the command does it, and of each interval that would be
printed it is asked whether it holds the truth. A run that was interrupted goes on where it stopped.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.commands.from_data_set import prepare
from oed.commands.identify import estimate
from oed.commands.options import Count, parse
from oed.commands.telling import speak
from oed.estimation.estimate import Estimate
from oed.process_end import RESUMES, leave
from oed.report.table import Row, markdown_table
from studies.case_runner import CaseRunner, Outcome, RowFile, leave_page, work_through
from studies.repeated_experiment import (
    ARMS,
    NOISES,
    PERIOD,
    RATE,
    REPETITIONS,
    SEED,
    Case,
    NoiseKind,
    simulate,
    truth_of,
)
from studies.study_options import CaseOptions

RUNS = "runs.csv"
KEY_COLUMNS = ("arm", "noise", "experiment")
VALUE_COLUMNS = ("status", "intervals", "seconds")
LEVEL = 0.95
MARK = (0.93, 0.97)  # between which the share must lie, over all parameters that are printed
OFTEN = 0.5  # of the experiments in which a parameter is printed, from which on it has a share of its own


@dataclass(frozen=True)
class Config:
    """What is simulated.

    Attributes:
        experiments: Of each arm and noise.
        noises: Of the logs.
    """

    experiments: int = 120
    noises: tuple[NoiseKind, ...] = NOISES


SMOKE = Config(experiments=1, noises=NOISES[:1])


def cases_of(config: Config) -> list[Case]:
    """All arms and noises in turn: a run that ends early has seen all."""
    return [
        Case(arm, noise, k)
        for k in range(config.experiments)
        for arm in ARMS
        for noise in config.noises
    ]


def work(case: Case) -> Outcome:
    """Identify a log as the command does it; the intervals that it would print, beside the truth."""
    start = time.process_time()
    truth = truth_of(case.arm)
    calibration = estimate(prepare(simulate(case)), robust=False)
    base = calibration.base.from_standard(truth.parameters)
    return {
        "status": calibration.estimate.status,
        "intervals": packed(calibration.estimate, base[list(calibration.estimate.columns)]),
        "seconds": round(time.process_time() - start, 2),
    }


def packed(found: Estimate, truth: Float[ndarray, " kept"]) -> str:
    """name:error/std:held for each parameter that is printed."""
    lower, upper = found.interval(LEVEL).T
    errors = (found.parameters - truth) / found.std
    held = (lower <= truth) & (truth <= upper)
    return " ".join(
        f"{name}:{error:.2f}:{int(is_held)}"
        for name, error, is_held, is_printed in zip(
            found.names, errors, held, found.determined, strict=True
        )
        if is_printed
    )


def unpacked(text: str) -> list[tuple[str, float, bool]]:
    """Name, error over std, and whether the interval holds it."""
    parts = (part.split(":") for part in text.split())
    return [(name, float(error), is_held == "1") for name, error, is_held in parts]


def summary_rows(rows: Sequence[Mapping[str, str]]) -> list[Row]:
    """A row an arm and noise."""
    cells: dict[tuple[str, str], list[Mapping[str, str]]] = defaultdict(list)
    for row in rows:
        if row["intervals"]:
            cells[row["arm"], row["noise"]].append(row)
    return [_summary(arm, noise, own) for (arm, noise), own in sorted(cells.items())]


def _summary(arm: str, noise: str, rows: Sequence[Mapping[str, str]]) -> Row:
    found = [unpacked(row["intervals"]) for row in rows]
    shares = np.array([np.mean([is_held for _, _, is_held in own]) for own in found])
    counts = np.array([len(own) for own in found])
    coverage = float(shares @ counts / counts.sum())
    # Of an experiment's parameters all share one noise: experiments are independent, not intervals.
    error = float(np.std((shares - coverage) * counts) / counts.mean() / np.sqrt(len(rows)))
    held, errors = defaultdict(list), defaultdict(list)
    for own in found:
        for name, size, is_held in own:
            held[name].append(is_held)
            errors[name].append(size)
    often = [name for name, own in held.items() if len(own) >= OFTEN * len(rows)]
    single = {name: float(np.mean(held[name])) for name in often}
    worst = min(single, key=single.__getitem__)
    bias = {name: float(np.mean(errors[name])) for name in often}
    most = max(bias, key=lambda name: abs(bias[name]))
    return {
        "arm": arm,
        "noise": noise,
        "experiments": len(rows),
        "printed": float(counts.mean()),
        "coverage": coverage,
        "+-": 1.96 * error,
        "within the mark": "yes" if MARK[0] <= coverage <= MARK[1] else "no",
        "least": f"{single[worst]:.3f} ({worst})",
        "largest mean error [std]": f"{bias[most]:.2f} ({most})",
        "seconds": float(np.mean([float(row["seconds"]) for row in rows])),
    }


def page(rows: Sequence[Mapping[str, str]]) -> str:
    """The summary."""
    failed = sum(not row["intervals"] for row in rows)
    fewest = min((int(str(row["experiments"])) for row in summary_rows(rows)), default=1)
    by_chance = 1.96 * np.sqrt(LEVEL * (1 - LEVEL) / max(fewest, 1))
    return (
        "# Coverage through the whole pipeline\n\n"
        f"{REPETITIONS} repetitions of a {PERIOD:g} s motion at {RATE:g} Hz, hard sign friction, 17-bit encoders, "
        "identified as `oed identify` does it. `coverage`: share of the printed 95 % intervals that hold the "
        f"truth, ± 1.96 standard errors over experiments; the mark is {MARK[0]} to {MARK[1]}. `least`: of the "
        f"parameters that are printed in at least {100 * OFTEN:g} % of the experiments, that covered worst; "
        f"chance alone spreads a single one by ± {by_chance:.3f}. `largest mean error`: of these parameters, in "
        "their own standard deviations. `seconds`: of CPU an experiment.\n\n"
        + markdown_table(summary_rows(rows), digits=3)
        + (f"\n{failed} experiments failed.\n" if failed else "")
    )


@dataclass(frozen=True)
class Options(CaseOptions):
    """Do the intervals that oed identify prints hold the truth, through its whole pipeline?

    Attributes:
        experiments: Of each arm and noise.
    """

    study: ClassVar[str] = "pipeline_coverage"
    names: ClassVar[tuple[str, ...]] = ("summary.md", "provenance.json")

    experiments: Count = Config.experiments


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 1 if all failed, else 0."""
    options = parse(Options, prog="python -m studies.pipeline_coverage", arguments=arguments)
    speak(quiet=True)
    config = SMOKE if options.smoke else Config(options.experiments)
    rows = RowFile(options.results / RUNS, KEY_COLUMNS, VALUE_COLUMNS)
    runner = CaseRunner(work, rows, "coverage")
    return work_through(
        runner,
        cases_of(config),
        options,
        config,
        lambda out: leave_page(page(rows.rows()), config, SEED, out),
    )


if __name__ == "__main__":
    leave(main, "studies.pipeline_coverage", RESUMES)
