"""The motion that `oed design --payload` finds for an arm of the studies, with the standstill about it."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np

from oed.commands.configurations import Design
from oed.commands.design_of_load import of_load
from oed.design.default_limits import with_default_limits
from oed.design.default_problem import ProblemSettings, default_problem
from oed.design.load_problem import LoadProblem
from oed.design.optimisers.interior_point import optimise
from oed.design.optimisers.result import Budget
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from studies.carrying_arms import ARMS
from studies.payload_arms import PERIOD

MARGIN = 0.9  # share of velocity and acceleration limits, as of the command
EVALUATIONS = 1000
STANDSTILL = 1.0  # [s] before and after


@cache
def designed_motion(arm: str, seconds: float) -> Motion:
    """The motion, sampled as a log is.

    Args:
        arm: Key of the arm.
        seconds: Length of the motion.
    """
    problem = problem_of(arm, seconds)
    z = problem.repair(optimise(problem, Budget(EVALUATIONS, None), np.random.default_rng(0)).z)
    moving = problem.trajectory.motion(z, np.arange(0.0, seconds, PERIOD))
    return _with_standstill(moving)


def problem_of(
    arm: str,
    seconds: float,
    *,
    trajectory: str = ProblemSettings.trajectory,
    harmonics: int = ProblemSettings.harmonics,
    instants: int = ProblemSettings.instants,
) -> LoadProblem:
    """The problem that `oed design --payload` solves.

    Args:
        arm: Key of the arm.
        seconds: Length of the motion.
        trajectory: Class of motions.
        harmonics: Of the Fourier series.
        instants: Sampled in a motion.
    """
    robot, _ = with_default_limits(ARMS[arm].robot)
    robot = robot.with_limits(robot.limits.slower(MARGIN))
    settings = ProblemSettings(
        horizon=seconds, trajectory=trajectory, harmonics=harmonics, instants=instants
    )
    alone = default_problem(build_model("standard", robot), settings).problem
    return of_load(alone, Design(robot=arm, out=Path(), payload=True))[0]


def _with_standstill(motion: Motion) -> Motion:
    """The motion, which begins and ends at rest, with the arm standing before and after it."""
    count = round(STANDSTILL / PERIOD)

    def padded(x: np.ndarray, mode: Literal["edge", "constant"]) -> np.ndarray:
        return np.pad(x, ((count, count), (0, 0)), mode=mode)

    t = PERIOD * np.arange(len(motion) + 2 * count)
    return Motion(
        t, padded(motion.q, "edge"), padded(motion.dq, "constant"), padded(motion.ddq, "constant")
    )
