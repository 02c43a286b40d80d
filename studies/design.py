"""From a robot's file to an excitation motion that provably keeps its limits.

    python -m studies.design --robot FILE|builtin:NAME --out DIR
    python -m studies.design --data DIR --out DIR

Writes the motion for a controller (CSV, ROS 2 JointTrajectory), `design.json`, the motion
against its limits, and a page in which the arm moves. Exit status: 0 with a motion; 2 for input
that cannot be used; 3 where no motion keeps all that it must, and then nothing for a controller
is written.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.bound.efficiency import QUICK, DEfficiency, NoBound, d_efficiency
from oed.design.clear_limits import ClearLimits, clear_limits
from oed.design.clearance import ClearanceCheck, check_clearance, clearance_status
from oed.design.collision import Surroundings
from oed.design.collision_free import avoid_collision
from oed.design.default_limits import with_default_limits
from oed.design.default_problem import ProblemSettings, default_problem
from oed.design.design import Design
from oed.design.design_file import design_record
from oed.design.export import (
    SetPoints,
    write_csv,
    write_joint_trajectory_json,
    write_joint_trajectory_yaml,
)
from oed.design.optimisers.interior_point import optimise
from oed.design.optimisers.result import Budget
from oed.design.prior_experiments import prior_information
from oed.design.problem import DesignProblem
from oed.design.still_joints import hold_still_joints
from oed.dynamics.models import MODELS, build_model
from oed.errors import NoUsableResult, OedError, RobotError
from oed.experiment.read_dataset import read_dataset
from oed.report.design_plots import draw_motion
from oed.report.json_file import write_json
from oed.report.motion_recording import FRAMES_PER_SECOND, record_motion
from oed.report.output_folder import named_folder
from oed.report.provenance import KEY_PACKAGES, Provenance, package_versions
from oed.report.study_files import DESIGN
from oed.report.style import save_figure
from oed.robot import Robot, load_arm
from studies.design_summary import summary
from studies.interrupt import BAD_INPUT, NO_USABLE_RESULT, leave

CHECKED_INSTANTS = 1000  # of the clearance check
MOST_POINTS = 1_000_000  # that a motion is written with
SMOKE_EVALUATIONS = 100  # a second on two joints
ROTORS = (
    "rotor inertias are no part of the model that this excites; studies.identify estimates them "
    "unless told otherwise: --model rotor excites them as well"
)


@dataclass(frozen=True)
class Config:
    """What to design.

    Attributes:
        robot: File or "builtin:NAME"; empty where a data set names it.
        data: Folder of a data set; empty where `robot` is given.
        joints: Names of the joints to move; empty for the arm proper.
        model: Name of the torque model whose parameters the motion is to excite.
        problem: What to ask of the motion.
        prior: Design files whose experiments this one completes.
        avoid_collision: Whether the motion must be clear of self-collision.
        box: Lower and upper x, y, z that no body's origin may leave [m]; empty for none.
        rate: Of the exported motion [Hz].
        evaluations: Of the criterion: the same number and seed give the same motion.
        budget: CPU time after which the optimiser stops in any case [s].
        quick_bound: Whether to spend a second on D-efficiency instead of ten.
        seed: Of starts, hops and the states of the bound.
    """

    robot: str = ""
    data: str = ""
    joints: tuple[str, ...] = ()
    model: str = "standard"
    problem: ProblemSettings = field(default_factory=ProblemSettings)
    prior: tuple[str, ...] = ()
    avoid_collision: bool = False
    box: tuple[float, ...] = ()
    rate: float = 100.0
    evaluations: int = 1000
    budget: float = 60.0
    quick_bound: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        for name, value in (
            ("rate", self.rate),
            ("budget", self.budget),
            ("horizon", self.problem.horizon),
        ):
            if not (value > 0 and np.isfinite(value)):
                raise ValueError(f"--{name} {value:g} is not a positive number")
        if self.rate * self.problem.horizon > MOST_POINTS:
            raise ValueError(
                f"--rate {self.rate:g} for --horizon {self.problem.horizon:g} is more than "
                f"{MOST_POINTS} set points"
            )
        if self.evaluations < 1:
            raise ValueError(f"--evaluations {self.evaluations} is not a positive number")
        if self.seed < 0:
            raise ValueError(f"--seed {self.seed} is negative")
        if self.box and not np.isfinite(self.box).all():
            raise ValueError("--box: a bound is not a finite number")
        if self.box and not (self.walls[:, 0] < self.walls[:, 1]).all():
            raise ValueError("--box: each lower bound must be below its upper bound")

    @property
    def keeps_clear(self) -> bool:
        """Whether a motion is to be moved away from what it may hit."""
        return self.avoid_collision or bool(self.box)

    @property
    def inputs(self) -> tuple[str, ...]:
        """What is read."""
        return tuple(given for given in (self.robot, self.data, *self.prior) if given)

    @property
    def walls(self) -> Float[ndarray, "3 2"]:
        """The box as lower and upper bounds of x, y, z."""
        return np.array(self.box).reshape(3, 2)


@dataclass(frozen=True)
class Result:
    """A design, what was assumed, what it is worth and what the geometry says of it."""

    design: Design
    notes: tuple[str, ...]
    efficiency: DEfficiency | None
    clearance: ClearanceCheck


def run(config: Config) -> Result:
    """Design a motion."""
    robot, held = hold_still_joints(_robot(config))
    robot, assumed = with_default_limits(robot)
    notes = [
        *robot.notes,
        *held,
        *assumed,
        *([ROTORS] if config.model == "standard" else []),
    ]
    rng = np.random.default_rng(config.seed)
    surroundings, unchecked = _surroundings(robot, config)
    room = None
    if config.keeps_clear:
        if surroundings is None or not (surroundings.has_shapes or config.box):
            reason = unchecked if surroundings is None else surroundings.note
            wish = "--avoid-collision" if config.avoid_collision else "--box"
            raise RobotError(f"{wish}: {reason}")
        room = clear_limits(robot.limits, surroundings, rng)
        robot = robot.with_limits(room.limits)
        notes += _narrowed(robot, room)
    posed = default_problem(build_model(config.model, robot), config.problem)
    problem = posed.problem
    notes += posed.notes
    if config.prior:
        problem = _with_prior(problem, config.prior)
    found = optimise(problem, Budget(config.evaluations, config.budget), rng)
    if found.evaluations < config.evaluations:
        notes.append(
            f"stopped by --budget {config.budget:g} CPU s after {found.evaluations} of "
            f"{config.evaluations} evaluations: the same seed may give another motion"
        )
    if room is not None and surroundings is not None:
        clear = avoid_collision(problem, found.z, surroundings, room.centre)
        notes.append(
            f"collisions avoided in {clear.rounds} rounds, motion times {clear.factor:.3g}"
        )
        found = dataclasses.replace(found, z=clear.z)
    design = Design.from_result(
        problem, found, optimiser="interior_point", seed=config.seed, others=posed.others
    )
    _check_information(design)
    seen = design.motion(np.linspace(0.0, design.horizon, CHECKED_INSTANTS))
    clearance = (
        ClearanceCheck.not_made(unchecked)
        if surroundings is None
        else check_clearance(surroundings, seen)
    )
    status = design.status.with_limits(
        clearance_status(clearance, is_asked=config.avoid_collision, has_box=bool(config.box))
    )
    design = dataclasses.replace(design, status=status)
    efficiency = None
    try:
        efficiency = d_efficiency(design, rng, QUICK if config.quick_bound else None)
    except NoBound as error:
        notes.append(f"D-efficiency not known: {error}")
    return Result(design, tuple(notes), efficiency, clearance)


def _check_information(design: Design) -> None:
    """Refuse a motion that leaves a base parameter without information."""
    if not np.isfinite(design.J_k):
        eigenvalues, vectors = np.linalg.eigh(design.information)
        name = design.problem.base.names[int(np.abs(vectors[:, 0]).argmax())]
        raise NoUsableResult(
            "the motion found tells nothing of some base parameters, least of "
            f"{name} (eigenvalues of Lambda {eigenvalues[0]:.1e} ... {eigenvalues[-1]:.1e}): "
            "widen the limits, lengthen --horizon, or leave out joints that hardly move (--joints)"
        )


def _robot(config: Config) -> Robot:
    if config.data:
        return read_dataset(config.data, joints=config.joints or None).robot
    return load_arm(config.robot, joints=config.joints)


def _surroundings(robot: Robot, config: Config) -> tuple[Surroundings | None, str]:
    """What may be hit; None with the reason where the robot has no geometry."""
    try:
        return Surroundings(robot, config.walls if config.box else None), ""
    except OedError as error:
        return None, f"not checked: {error}"


def _with_prior(problem: DesignProblem, files: Sequence[str]) -> DesignProblem:
    try:
        return dataclasses.replace(problem, prior=prior_information(files, problem))
    except ValueError as error:
        raise ValueError(f"--prior {error}") from error


def _narrowed(robot: Robot, room: ClearLimits) -> list[str]:
    return [
        f"position of {name}: narrowed to {lower:.3g} ... {upper:.3g}, so that collisions are rare"
        for name, (lower, upper), factor in zip(
            robot.joint_names, room.limits.position, room.factors, strict=True
        )
        if factor < 1.0
    ]


def write(result: Result, config: Config, out: Path) -> tuple[str, ...]:
    """Write motion files, `design.json`, plot, recording and provenance; all notes.

    Nothing that a controller could run where the motion is not usable.
    """
    design = result.design
    robot = design.problem.model.robot
    if design.status.is_usable:
        _write_for_controller(design, config, out)
    fine = design.motion(np.linspace(0.0, design.horizon, 1000))
    nominal = design.problem.nominal
    torque = None if nominal is None else design.problem.model.torque(nominal, fine)
    figure = draw_motion(fine, robot.joint_names, robot.limits, design.certificate, torque)
    save_figure(figure, out / "motion", formats=("png",))
    frames = design.motion(np.arange(0.0, design.horizon, 1 / FRAMES_PER_SECOND))
    note = record_motion(robot, frames, out / "motion.html")
    notes = (*result.notes, *((note,) if note else ()))
    record = design_record(
        design,
        versions=package_versions(KEY_PACKAGES),
        d_efficiency=None if result.efficiency is None else dataclasses.asdict(result.efficiency),
        notes=notes,
    )
    more: dict[str, object] = {"evaluations_asked": config.evaluations}
    more |= {"model": config.model, "prior": list(config.prior), "clearance": result.clearance}
    write_json(out / "design.json", {**record, **more})
    Provenance.collect(config, seed=config.seed).write(out / "provenance.json")
    return notes


def _write_for_controller(design: Design, config: Config, out: Path) -> None:
    problem = design.problem
    points = SetPoints.sample(
        problem.trajectory, design.z, problem.model.robot.joint_names, config.rate
    )
    write_csv(points, out / "motion.csv")
    write_joint_trajectory_yaml(points, out / "joint_trajectory.yaml")
    write_joint_trajectory_json(points, out / "joint_trajectory.json")


def main(argv: Sequence[str] | None = None) -> int:
    """Run from the command line; the exit status as in the module's docstring."""
    parser = argparse.ArgumentParser(
        prog="studies.design", description=(__doc__ or "").partition("\n")[0]
    )
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--robot", default="", help="URDF, SDF or MJCF file, or builtin:NAME")
    source.add_argument("--data", default="", help="folder of a data set")
    parser.add_argument("--out", type=named_folder, required=True)
    parser.add_argument("--joints", nargs="+", default=())
    parser.add_argument("--model", choices=sorted(MODELS), default=Config.model)
    parser.add_argument("--horizon", type=float, default=ProblemSettings.horizon, help="[s]")
    parser.add_argument(
        "--criterion", choices=("J_k", "J_d", "A", "E"), default=ProblemSettings.criterion
    )
    parser.add_argument("--at-rest", action="store_true")
    parser.add_argument("--no-torque", action="store_true", help="ignore effort limits")
    parser.add_argument(
        "--scaled-columns", action="store_true", help="for J_k, A and E: J_k_scaled and so on"
    )
    parser.add_argument("--prior", nargs="+", default=(), help="design.json of earlier experiments")
    parser.add_argument("--avoid-collision", action="store_true")
    parser.add_argument(
        "--box",
        nargs=6,
        type=float,
        default=(),
        metavar=("X0", "X1", "Y0", "Y1", "Z0", "Z1"),
        help="that no body's origin may leave [m]",
    )
    parser.add_argument("--rate", type=float, default=Config.rate, help="[Hz]")
    parser.add_argument("--seed", type=int, default=Config.seed)
    parser.add_argument(
        "--evaluations", type=int, help=f"of the criterion; {Config.evaluations} if not given"
    )
    parser.add_argument("--budget", type=float, default=Config.budget, help="most CPU seconds")
    parser.add_argument("--smoke", action="store_true", help="a few seconds, to see it work")
    given = parser.parse_args(argv)
    try:
        config = _config(given)
        with DESIGN.in_folder(given.out, config.inputs) as results:
            result = run(config)
            with results.replaced() as new:
                notes = write(result, config, new)
    except (OedError, ValueError, OSError) as error:
        # Drake's messages have several lines.
        sys.stderr.write(f"studies.design: {' '.join(str(error).split())}\n")
        return NO_USABLE_RESULT if isinstance(error, NoUsableResult) else BAD_INPUT
    told = summary(result.design, result.efficiency, result.clearance, notes)
    sys.stdout.write(f"{told}\n  written to {given.out}\n")
    if result.design.status.is_usable:
        return 0
    sys.stderr.write(
        "studies.design: no motion for a controller was written: a limit is not kept (see status)\n"
    )
    return NO_USABLE_RESULT


def _config(given: argparse.Namespace) -> Config:
    return Config(
        robot=given.robot,
        data=given.data,
        joints=tuple(given.joints),
        model=given.model,
        problem=ProblemSettings(
            horizon=given.horizon,
            instants=40 if given.smoke else ProblemSettings.instants,
            criterion=given.criterion,
            at_rest=given.at_rest,
            torque=not given.no_torque,
            scaled=given.scaled_columns,
        ),
        prior=tuple(given.prior),
        avoid_collision=given.avoid_collision,
        box=tuple(given.box),
        rate=given.rate,
        evaluations=_evaluations(given),
        budget=given.budget,
        quick_bound=given.smoke,
        seed=given.seed,
    )


def _evaluations(given: argparse.Namespace) -> int:
    if given.evaluations is not None:
        return given.evaluations
    return SMOKE_EVALUATIONS if given.smoke else Config.evaluations


if __name__ == "__main__":
    leave(main, "studies.design")
