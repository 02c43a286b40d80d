"""The design problem of an arm that comes with a file and no wishes."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.criteria import Criterion, column_scaling
from oed.design.effort import check_room, find_stand
from oed.design.joint_sums import roomiest_posture
from oed.design.problem import DENSE, DesignProblem
from oed.design.status import LimitStatus
from oed.design.torque_range import check_torque_bounded
from oed.design.trajectories import FourierClass
from oed.design.trajectories.registry import Wishes, make_trajectory
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.errors import RobotError
from oed.robot import Robot
from oed.robot.placeholder_inertia import placeholder_reasons

SCALING_STARTS = 5  # random motions whose mean information gives each column its unit
SCALING_SEED = 0  # of these motions: what a scaled criterion means does not depend on a seed
TORQUE = "torque"


@dataclass(frozen=True)
class ProblemSettings:
    """What to ask of a motion.

    Attributes:
        horizon: Period of the motion [s].
        trajectory: Name of the class of motions.
        harmonics: Of the Fourier series, or sines, a joint.
        instants: Sampled in a period.
        criterion: "J_k", "J_d", "A" or "E".
        at_rest: Whether the motion starts and ends at rest.
        torque: Whether the file's effort limits hold for the file's own inertia.
        scaled: Whether columns are scaled before J_k, A and E are taken: to unit diagonal of the
            mean information of a few random motions, always the same for an arm.
    """

    horizon: float = 10.0
    trajectory: str = FourierClass.name
    harmonics: int = 5
    instants: int = 200
    criterion: Criterion = "J_d"
    at_rest: bool = True
    torque: bool = True
    scaled: bool = False


@dataclass(frozen=True)
class DefaultProblem:
    """A problem, and what was assumed in posing it.

    Attributes:
        problem: Complete.
        notes: What was assumed, a line each.
        others: Limits of the robot that the problem does not hold, and why.
    """

    problem: DesignProblem
    notes: tuple[str, ...]
    others: tuple[LimitStatus, ...]


@dataclass(frozen=True)
class _Nominal:
    """What torque is predicted by.

    Attributes:
        parameters: (p,) of the model; None where torque is not limited.
        stand: (n,) a posture that the effort limits allow; None likewise.
        notes: What was assumed.
        others: Effort limits that are not held, and why.
    """

    parameters: Float[ndarray, " parameters"] | None = None
    stand: Float[ndarray, " joints"] | None = None
    notes: tuple[str, ...] = ()
    others: tuple[LimitStatus, ...] = ()


def default_problem(model: TorqueModel, settings: ProblemSettings) -> DefaultProblem:
    """A design for a model whose robot has finite limits.

    Args:
        model: Of the torque.
        settings: What to ask.

    Raises:
        ValueError: If no class of motions has the name.
        RobotError: If torque is to be limited and the file states a mass that is not positive.
        EffortTooSmall: If the effort limits leave no room for a design.
    """
    robot = model.robot
    base = base_parameters(model)
    wishes = Wishes(robot.limits, settings.horizon, settings.harmonics, settings.at_rest)
    trajectory = make_trajectory(settings.trajectory, wishes)
    nominal = _nominal(model, enabled=settings.torque)
    problem = DesignProblem(
        model,
        base,
        trajectory,
        robot.limits,
        trajectory.instants(settings.instants),
        settings.criterion,
        nominal=nominal.parameters,
        stand=nominal.stand,
    )
    _check_room(problem)
    if settings.scaled:
        problem = dataclasses.replace(problem, scaling=_scaling(problem))
    notes = (*nominal.notes, *((base.note,) if base.note else ()))
    return DefaultProblem(problem, notes, nominal.others)


def _scaling(problem: DesignProblem) -> Float[ndarray, " base"]:
    rng = np.random.default_rng(SCALING_SEED)
    starts = [problem.random_start(rng) for _ in range(SCALING_STARTS)]
    return column_scaling(np.mean([problem.information(z) for z in starts], axis=0))


def _nominal(model: TorqueModel, *, enabled: bool) -> _Nominal:
    """The file's own inertia and nothing else, where it can be held against effort limits."""
    robot = model.robot
    if not np.isfinite(robot.limits.torque).any():
        return _Nominal(notes=("torque is not limited: the robot's file states no effort limits",))
    if not enabled:
        return _Nominal(others=(LimitStatus(TORQUE, "given up", "--no-torque"),))
    if not np.any(robot.parameters):
        reason = "the robot's file states effort limits and no inertia"
        return _Nominal(others=(LimitStatus(TORQUE, "not checked", reason),))
    _check_mass(robot)
    nominal = np.zeros(len(model.parameters))
    nominal[: len(robot.parameters)] = robot.parameters
    check_torque_bounded(model, nominal[None])
    stand = find_stand(model, nominal[None])
    notes = ["torque is limited for the file's own inertia, friction not counted"]
    notes += [
        f"that inertia is a placeholder ({reason}): torque that is proven for it is not proven for the "
        "arm; correct the file, or design for an identified model (--model)"
        for reason in placeholder_reasons(robot)
    ]
    if not np.array_equal(stand.posture, roomiest_posture(robot.limits)):
        posture = ", ".join(f"{q:.3g}" for q in stand.posture)
        notes.append(
            "the arm cannot hold itself within its effort limits at mid-range: motions that need "
            f"too much torque are brought towards the posture {posture}"
        )
    return _Nominal(nominal, stand.posture, tuple(notes))


def _check_room(problem: DesignProblem) -> None:
    """Refuse effort limits that leave hardly any motion."""
    if problem.nominal is None:
        return
    free = dataclasses.replace(problem, nominal=None)
    rng = np.random.default_rng(SCALING_SEED)
    starts = [free.random_start(rng) for _ in range(SCALING_STARTS)]
    t = np.linspace(0.0, problem.trajectory.horizon, DENSE)
    motions = [problem.trajectory.motion(z, t) for z in starts]
    shares = [problem.torque_factor(z) for z in starts]
    check_room(problem.model, problem.nominal, motions, shares)


def _check_mass(robot: Robot) -> None:
    """Refuse to limit torques by masses that cannot be."""
    for fault in robot.inertia_faults:
        if not fault.has_mass:
            raise RobotError(
                f"{robot.source}: {fault.text}, so torque cannot be held against effort limits; "
                "correct the file, or design without torque limits (--no-torque)"
            )
