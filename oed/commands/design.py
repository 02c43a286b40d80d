"""`oed design`: an excitation motion that provably keeps its limits."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.commands.configurations import Design
from oed.commands.design_of_load import of_load, run_static, worth_of_load
from oed.commands.design_of_model import of_model
from oed.commands.design_output import Result, evaluations_of, told_of, write
from oed.commands.telling import say, speak
from oed.counted import counted
from oed.design.bound.efficiency import QUICK, NoBound, d_efficiency
from oed.design.clear_search import search_clear
from oed.design.clearance import ClearanceCheck, clearance_status, prove_clearance
from oed.design.collision import Surroundings
from oed.design.criteria import Criterion
from oed.design.default_limits import with_default_limits
from oed.design.default_problem import DefaultProblem, ProblemSettings, default_problem
from oed.design.design import Design as FoundDesign
from oed.design.load_problem import LoadProblem
from oed.design.optimisers.registry import find_optimiser
from oed.design.optimisers.result import Budget
from oed.design.prior_experiments import prior_information
from oed.design.problem import DesignProblem
from oed.design.status import DesignStatus, LimitStatus
from oed.design.still_joints import hold_still_joints
from oed.dynamics.models import build_model
from oed.errors import NoUsableResult, OedError, RobotError
from oed.experiment.read_dataset import read_robot
from oed.export.model_file import load_model, model_file_at
from oed.one_thread import on_one_thread
from oed.process_end import NO_USABLE_RESULT
from oed.progress import tell
from oed.report.design_summary import summary
from oed.report.study_files import DESIGN
from oed.robot import JointSum, Robot, load_arm, read_sum
from oed.robot.load import EARTH_GRAVITY
from oed.robot.packages import read_packages

SMOKE_INSTANTS = 40  # enough for the rank of two joints' base parameters
ROTORS = (
    "rotor inertias are no part of the model that this excites; oed identify estimates them "
    "unless told otherwise: --model rotor excites them as well"
)


@on_one_thread
def design_motion(
    robot: Robot | str | Path,
    *,
    horizon: float = Design.horizon,
    criterion: Criterion = Design.criterion,
    clearance: float = Design.clearance,
    margin: float = Design.margin,
    evaluations: int = Design.evaluations,
    seed: int = Design.seed,
) -> Result:
    """Find the motion that excites an arm best, and prove that it keeps its limits.

    It is clear of itself where shapes are known, and from rest to rest.

    Args:
        robot: A robot, its file, or "builtin:NAME".
        horizon: Length of the motion [s].
        criterion: "J_d" (log10 det of the information), "J_k" (its condition number), "A" or "E".
        clearance: Distance that links keep from one another [m].
        margin: Share of velocity and acceleration limits that is used.
        evaluations: Of the criterion; the same number and seed give the same motion.
        seed: Of starts and of the states of the bound.

    Raises:
        RobotError: If the file cannot be used.
        NoUsableResult: If no motion tells anything of some base parameter.
    """
    source = robot.name if isinstance(robot, Robot) else str(robot)
    config = Design(
        robot=source,
        out=Path(),
        horizon=horizon,
        criterion=criterion,
        clearance=clearance,
        margin=margin,
        evaluations=evaluations,
        seed=seed,
    )
    return find(config, robot if isinstance(robot, Robot) else robot_of(config))


def find(config: Design, robot: Robot, *, bounded: bool = True) -> Result:
    """Design a motion for a robot, as a command asks for it.

    Args:
        config: What is asked for.
        robot: For which.
        bounded: Whether it is said how much better any motion could be; the motion is the same.
    """
    optimise = find_optimiser(config.optimiser)
    robot = robot.with_limits(robot.limits.with_sums(_sums(robot, config)))
    robot, held = hold_still_joints(robot)
    robot, assumed = with_default_limits(robot.with_packages(read_packages(config.package)))
    limits = robot.limits
    robot = robot.with_limits(limits.slower(config.margin))
    notes = [
        *robot.notes,
        *held,
        *assumed,
        *([ROTORS] if config.model == "standard" and not config.payload else []),
    ]
    rng = np.random.default_rng(config.seed)
    surroundings, unchecked = _surroundings(robot, config)
    posed, told = _posed(config, robot)
    problem = posed.problem
    notes += [*posed.notes, *told]
    if config.payload:
        problem, told = of_load(problem, config)
        notes += told
    if config.prior:
        problem = _with_prior(problem, config.prior)
    kept = _kept(surroundings, robot, config)
    slowed = _slowed(problem, config)
    budget = Budget(evaluations_of(config), config.budget)
    search = search_clear(problem, kept, budget, rng, optimise)
    found, beyond = search.found, search.found.evaluations - evaluations_of(config)
    if search.is_cut_short:
        notes.append(
            f"stopped by --budget {config.budget:g} CPU s after "
            f"{counted(found.evaluations, 'evaluation')}: the same seed may give another motion"
        )
    if beyond > 0:
        why = "until a motion was clear" if search.is_kept_on else f"by {config.optimiser} itself"
        notes.append(
            f"{counted(beyond, 'evaluation')} beyond the {evaluations_of(config)} of --evaluations, {why}"
        )
    tell("proving what the motion keeps", 0, None)  # a search that ended early is over
    say(f"found after {counted(found.evaluations, 'evaluation')}; proving what it keeps")
    problem = slowed
    design = FoundDesign.from_result(
        problem, found, optimiser=config.optimiser, seed=config.seed, others=posed.others
    )
    _check_information(design)
    clearance = search.check if config.scale == 1.0 else None
    if surroundings is None:
        clearance = ClearanceCheck.not_made(unchecked)
    elif clearance is None or config.no_clearance:
        clearance = prove_clearance(surroundings, problem.trajectory, design.z)
    design = dataclasses.replace(design, status=_status(design, clearance, config))
    efficiency = None
    if bounded and isinstance(problem, LoadProblem):
        say("bounding how much better any motion could be")
        notes.append(worth_of_load(problem, design.z, rng, is_quick=config.smoke))
    elif bounded:
        say("bounding how much better any motion could be")
        try:
            efficiency = d_efficiency(design, rng, QUICK if config.smoke else None)
        except NoBound as error:
            notes.append(f"D-efficiency not known: {error}")
    before = None if search.free is None else problem.worth(search.free)
    return Result(design, limits, tuple(notes), efficiency, clearance, before)


def _posed(config: Design, robot: Robot) -> tuple[DefaultProblem, tuple[str, ...]]:
    """The problem of the model that is meant, and what was assumed of that."""
    if isinstance(config.model, Path):
        return of_model(config.model, robot, _problem(config))
    return default_problem(build_model(config.model, robot), _problem(config)), ()


def _sums(robot: Robot, config: Design) -> list[JointSum]:
    """The bounds on sums of positions that are asked for."""
    try:
        read = [read_sum(text, (*robot.joint_names, *robot.locked)) for text in config.sum]
        sums = [JointSum.of(*each, robot.joint_names, robot.held) for each in read]
    except ValueError as error:
        raise ValueError(f"--sum: {error}") from error
    return [each for each in sums if each is not None]


def _kept(surroundings: Surroundings | None, robot: Robot, config: Design) -> Surroundings | None:
    """What the motion must keep clear of; None where there is nothing."""
    has_shapes = surroundings is not None and surroundings.has_shapes
    if config.avoid_collision and not has_shapes:
        reason = "it has no file" if surroundings is None else surroundings.note
        raise RobotError(f"--avoid-collision: {reason}")
    if surroundings is None:
        if config.box:
            raise RobotError(f"--box: {robot.name} does not come from a file: it has no geometry")
        return None
    if not config.no_clearance:
        return surroundings if has_shapes or config.box else None
    return Surroundings(robot, _walls(config), walls_only=True) if config.box else None


def _status(design: FoundDesign, clearance: ClearanceCheck, config: Design) -> DesignStatus:
    """The status with what is kept besides limits."""
    rest = LimitStatus("rest to rest", "proven" if not config.periodic else "given up")
    return design.status.with_limits(
        (
            rest,
            *clearance_status(
                clearance,
                is_wanted=not config.no_clearance,
                is_asked=config.avoid_collision,
                has_box=config.box is not None,
            ),
        )
    )


def _check_information(design: FoundDesign) -> None:
    """Refuse a motion that leaves a base parameter without information."""
    if not np.isfinite(design.J_k):
        eigenvalues, vectors = np.linalg.eigh(design.information)
        name = design.problem.base.names[int(np.abs(vectors[:, 0]).argmax())]
        raise NoUsableResult(
            "the motion found tells nothing of some base parameters, least of "
            f"{name} (eigenvalues of Lambda {eigenvalues[0]:.1e} ... {eigenvalues[-1]:.1e}): "
            "widen the limits, lengthen --horizon, or leave out joints that hardly move (--joints)"
        )


def _slowed(problem: DesignProblem, config: Design) -> DesignProblem:
    """The problem at the speed that is asked for, before the search for its answer."""
    try:
        return problem.slower(config.scale)
    except ValueError as error:
        raise ValueError(f"--trajectory {config.trajectory} with --scale: {error}") from error


def _problem(config: Design) -> ProblemSettings:
    return ProblemSettings(
        horizon=config.horizon,
        trajectory=config.trajectory,
        instants=SMOKE_INSTANTS if config.smoke else ProblemSettings.instants,
        criterion=config.criterion,
        at_rest=not config.periodic,
        torque=not config.no_torque,
        scaled=config.scaled_columns,
    )


def _walls(config: Design) -> Float[ndarray, "3 2"]:
    """The box as lower and upper bounds of x, y, z; empty where there is none."""
    return np.array(config.box or ()).reshape(-1, 2)


def robot_of(config: Design) -> Robot:
    """The robot that a command names."""
    if config.data:
        return read_robot(config.data, joints=config.joints or None)
    if not config.robot:
        return load_model(model_file_at(Path(config.model))).robot
    gravity = config.gravity or EARTH_GRAVITY
    return load_arm(config.robot, joints=config.joints, gravity=gravity)


def _surroundings(robot: Robot, config: Design) -> tuple[Surroundings | None, str]:
    """What may be hit; None with the reason where the robot has no geometry."""
    clearance = config.clearance if not config.no_clearance else 0.0
    try:
        return Surroundings(robot, _walls(config) if config.box else None, clearance), ""
    except OedError as error:
        return None, f"not checked: {error}"


def _with_prior(problem: DesignProblem, files: Sequence[str]) -> DesignProblem:
    known = 0.0 if problem.prior is None else problem.prior
    try:
        return dataclasses.replace(problem, prior=known + prior_information(files, problem))
    except ValueError as error:
        raise ValueError(f"--prior {error}") from error


def run(config: Design) -> int:
    """Design, and leave the motion, its proof and its pictures; the exit status."""
    speak(quiet=config.quiet)
    if config.static:
        return run_static(config, robot_of(config))
    with DESIGN.in_folder(config.out, config.inputs) as results:
        result = find(config, robot_of(config))
        with results.replaced() as new:
            notes = write(result, config, new)
    told = told_of(result, config, notes)
    print(summary(result.design, result.efficiency, result.clearance, told))
    print(f"open {config.out / 'report.html'}")
    if result.design.status.is_usable:
        return 0
    sys.stderr.write(
        "oed design: no motion for a controller was written: a limit is not kept (see status)\n"
    )
    return NO_USABLE_RESULT
