"""`oed design`: an excitation motion that provably keeps its limits."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from oed.commands.configurations import Design
from oed.commands.design_in_doubt import (
    robust_of,
    search_in_doubt,
    torque_in_doubt,
    worth_in_doubt,
)
from oed.commands.design_of_load import of_load, run_static, worth_of_load
from oed.commands.design_of_model import of_model
from oed.commands.design_output import Result, evaluations_of, told_of, write
from oed.commands.design_surroundings import kept_clear_of, surroundings_of
from oed.commands.telling import say, speak
from oed.counted import counted
from oed.design.bound.efficiency import QUICK, DEfficiency, NoBound, d_efficiency
from oed.design.clear_search import ClearSearch
from oed.design.clearance import ClearanceCheck, clearance_status, prove_clearance
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
from oed.errors import NoUsableResult
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
        evaluations: Evaluations of the criterion; the same number and seed give the same motion.
        seed: Seed of the starts and of the states of the bound.

    Returns:
        The `design` with its status and proof, the `limits` that it was made for, and `notes` that say
        what was assumed.

    Raises:
        RobotError: If the file cannot be used.
        NoUsableResult: If no motion tells anything of some base parameter. A limit that is not kept
            raises nothing: the design's status names it.
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
    surroundings, unchecked = surroundings_of(robot, config)
    posed, told = _posed(config, robot)
    problem = posed.problem
    notes += [*posed.notes, *told]
    if config.payload:
        problem, told = of_load(problem, config)
        notes += told
    if config.prior:
        problem = _with_prior(problem, config.prior)
    problem, told = robust_of(problem, config)
    notes += told
    kept = kept_clear_of(surroundings, robot, config)
    slowed = _slowed(problem, config)
    budget = Budget(evaluations_of(config), config.budget)
    searched = search_in_doubt(problem, kept, budget, rng, optimise)
    search = searched.search
    notes += searched.notes
    notes += _told_of_search(search, config)
    found = search.found
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
    efficiency, told = _efficiency(design, rng, config) if bounded else (None, ())
    notes += told
    doubt = worth_in_doubt(problem, searched.nominal, design.z)
    before = None if search.free is None else problem.worth(search.free)
    return Result(design, limits, tuple(notes), efficiency, clearance, before, doubt)


def _told_of_search(search: ClearSearch, config: Design) -> list[str]:
    """Where a search took less or more than it was given."""
    notes = []
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
    return notes


def _efficiency(
    design: FoundDesign, rng: np.random.Generator, config: Design
) -> tuple[DEfficiency | None, tuple[str, ...]]:
    """What a motion is worth against the best that any could be, or why that is not known."""
    say("bounding how much better any motion could be")
    if isinstance(design.problem, LoadProblem):
        return None, (worth_of_load(design.problem, design.z, rng, is_quick=config.smoke),)
    try:
        return d_efficiency(design, rng, QUICK if config.smoke else None), ()
    except NoBound as error:
        return None, (f"D-efficiency not known: {error}",)


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


def _status(design: FoundDesign, clearance: ClearanceCheck, config: Design) -> DesignStatus:
    """The status with what is kept besides limits."""
    rest = LimitStatus("rest to rest", "proven" if not config.periodic else "given up")
    return design.status.with_limits(
        (
            *torque_in_doubt(design),
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


def robot_of(config: Design) -> Robot:
    """The robot that a command names."""
    if config.data:
        return read_robot(config.data, joints=config.joints or None)
    if not config.robot:
        return load_model(model_file_at(Path(config.model))).robot
    gravity = config.gravity or EARTH_GRAVITY
    return load_arm(config.robot, joints=config.joints, gravity=gravity)


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
