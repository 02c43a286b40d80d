"""One estimator on the logs of one condition: what its torque errs, and whether its intervals hold."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.errors import OedError
from studies.case_runner import Outcome
from studies.estimators import linear, ours, simulating
from studies.estimators.arms import SEED, arm_of
from studies.estimators.conditions import CONDITIONS, Logs, logs_of, motion_of
from studies.estimators.loop import PERIOD
from studies.estimators.recipe import Equations, Found, Recipe

KEY = ("arm", "condition", "method")
VALUES = (
    "status", "draws", "failed", "bias", "spread", "error", "covered", "intervals", "seconds",
)  # fmt: skip
TEST_THINNING = 20  # control periods a row of the motion that is predicted
Method = Callable[[str, Logs], list[Found | None]]


def _each(one: Callable[[str, Logs, int], Found]) -> Method:
    """A method that works log by log; what it refuses is None."""

    def every(key: str, logs: Logs) -> list[Found | None]:
        found: list[Found | None] = []
        for draw in range(len(logs.q)):
            try:
                found.append(one(key, logs, draw))
            except (OedError, ValueError):
                found.append(None)
        return found

    return every


def _of_equations(solve: Callable[[Equations], Found]) -> Method:
    """A method of linear equations, after the usual signal processing."""

    def one(key: str, logs: Logs, draw: int) -> Found:
        recipe = Recipe(1 / (logs.every * PERIOD))
        return solve(recipe.equations(arm_of(key), logs.q[draw], logs.tau[draw]))

    return _each(one)


METHODS: dict[str, Method] = {
    "ours, HAC": _each(ours.plain),
    "ours, Huber": _each(ours.huber),
    "IDIM-LS": _of_equations(linear.ordinary),
    "IDIM-IV": simulating.instruments,
    "DIDIM": simulating.direct,
    "output error": simulating.output_error,
    "input error": simulating.input_error,
    "total LS": _of_equations(linear.total),
    "ridge": _of_equations(linear.ridge),
    "truncated SVD": _of_equations(linear.truncated),
    "feasible": _each(ours.feasible),
    "feasible, prior": _each(ours.feasible_prior),
}


@dataclass(frozen=True)
class Case:
    """One estimator on the logs of one condition.

    Attributes:
        arm: Key of the arm.
        condition: Name of what the recording is like.
        method: Name of the estimator.
        draws: Logs.
    """

    arm: str
    condition: str
    method: str
    draws: int

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        return (self.arm, self.condition, self.method)


def work(case: Case) -> Outcome:
    """Errors of a method's torque on a motion that was not recorded, and whether intervals hold."""
    arm, logs = arm_of(case.arm), logs_of(case.arm, CONDITIONS[case.condition], case.draws)
    start = time.process_time()
    every = METHODS[case.method](case.arm, logs)
    seconds = (time.process_time() - start) / case.draws
    found = [each for each in every if each is not None]
    if not found:
        return {
            "status": "failed: no log gave an estimate",
            "draws": case.draws,
            "failed": case.draws,
        }
    motion = motion_of(arm, np.random.default_rng([SEED, 1]))[::TEST_THINNING]
    columns = arm.model.columns(motion)[:, :, arm.base.columns]
    torque = columns @ arm.truth
    errors = np.array([(columns @ x.parameters - torque) for x in found])
    errors /= np.sqrt(np.mean(torque**2, axis=0))
    intervals = np.array([x.interval for x in found])
    told = np.isfinite(intervals).all(axis=2)
    held = (intervals[..., 0] <= arm.truth) & (arm.truth <= intervals[..., 1]) & told
    return {
        "status": "ok",
        "draws": case.draws,
        "failed": case.draws - len(found),
        "bias": _rounded(_rms(errors.mean(axis=0))),
        "spread": _rounded(_rms(errors - errors.mean(axis=0))),
        "error": _rounded(_rms(errors)),
        "covered": int(held.sum()),
        "intervals": int(told.sum()),
        "seconds": _rounded(seconds),
    }


def _rms(values: Float[ndarray, "*any"]) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")
