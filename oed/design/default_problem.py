"""The design problem of an arm that comes with a file and no wishes."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.criteria import Criterion, column_scaling
from oed.design.problem import DesignProblem
from oed.design.torque_range import check_torque_bounded
from oed.design.trajectories import FourierClass
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.errors import RobotError
from oed.robot import Robot

STANDING_SHARE = 0.9  # of an effort limit that gravity alone may take
CANNOT_STAND = (
    "torque is not limited: by the file's inertia the arm cannot even hold itself within its "
    "effort limits at mid-range"
)
SCALING_STARTS = 5  # random motions whose mean information gives each column its unit


@dataclass(frozen=True)
class ProblemSettings:
    """What to ask of a motion.

    Attributes:
        horizon: Period of the motion [s].
        harmonics: Of the Fourier series.
        instants: Sampled in a period.
        criterion: "J_k", "J_d", "A" or "E".
        at_rest: Whether the motion starts and ends at rest.
        torque: Whether the file's effort limits hold for the file's own inertia.
    """

    horizon: float = 10.0
    harmonics: int = 5
    instants: int = 200
    criterion: Criterion = "J_d"
    at_rest: bool = False
    torque: bool = True


def default_problem(
    model: TorqueModel, settings: ProblemSettings, rng: np.random.Generator
) -> tuple[DesignProblem, tuple[str, ...]]:
    """A Fourier design for a model whose robot has finite limits.

    Columns are scaled to unit diagonal of the information of random motions, so that criteria
    other than J_d do not depend on the parameters' units.

    Args:
        model: Of the torque.
        settings: What to ask.
        rng: Of the random motions.

    Returns:
        The problem, and notes on what was assumed or left out.

    Raises:
        RobotError: If torque is to be limited and the file states a mass that is not positive.
    """
    robot = model.robot
    base = base_parameters(model)
    trajectory = FourierClass(settings.horizon, robot.limits, settings.harmonics, settings.at_rest)
    nominal, note = _nominal(model, enabled=settings.torque)
    problem = DesignProblem(
        model,
        base,
        trajectory,
        robot.limits,
        trajectory.instants(settings.instants),
        settings.criterion,
        nominal=nominal,
    )
    starts = [problem.random_start(rng) for _ in range(SCALING_STARTS)]
    typical = np.mean([problem.information(z) for z in starts], axis=0)
    scaled = dataclasses.replace(problem, scaling=column_scaling(typical))
    replaced = () if nominal is None else _replaced(robot)
    return scaled, (note, *replaced, *((base.note,) if base.note else ()))


def _nominal(
    model: TorqueModel, *, enabled: bool
) -> tuple[Float[ndarray, " parameters"] | None, str]:
    """The file's own inertia and nothing else, where it can be held against effort limits."""
    robot = model.robot
    if not enabled:
        return None, "torque is not limited: switched off"
    if not np.isfinite(robot.limits.torque).any():
        return None, "torque is not limited: the robot's file states no effort limits"
    if not np.any(robot.parameters):
        return None, "torque is not limited: the robot's file states no inertia"
    _check_mass(robot)
    nominal = np.zeros(len(model.parameters))
    nominal[: len(robot.parameters)] = robot.parameters
    check_torque_bounded(model, nominal)
    standing = model.torque(nominal, _still(robot))[0]
    if (np.abs(standing) > STANDING_SHARE * np.abs(robot.limits.torque).min(axis=1)).any():
        return None, CANNOT_STAND
    return nominal, "torque is limited for the file's own inertia, friction not counted"


def _check_mass(robot: Robot) -> None:
    """Refuse to limit torques by masses that cannot be."""
    for fault in robot.inertia_faults:
        if not fault.has_mass:
            raise RobotError(
                f"{robot.source}: {fault.text}, so torque cannot be held against effort limits; "
                "correct the file, or design without torque limits (--no-torque)"
            )


def _replaced(robot: Robot) -> tuple[str, ...]:
    return tuple(
        f"{fault.text}; a ball of the same mass was taken in its place"
        for fault in robot.inertia_faults
    )


def _still(robot: Robot) -> Motion:
    middle = robot.limits.position.mean(axis=1)[None]
    return Motion(np.zeros(1), middle, np.zeros_like(middle), np.zeros_like(middle))
