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
from oed.design.clear_search import search_clear
from oed.design.clearance import ClearanceCheck, clearance_status, prove_clearance
from oed.design.collision import CLEARANCE, FAR, Surroundings
from oed.design.default_limits import with_default_limits
from oed.design.default_problem import ProblemSettings, default_problem
from oed.design.design import Design
from oed.design.design_file import design_record, limits_record
from oed.design.export import (
    SetPoints,
    write_csv,
    write_joint_trajectory_json,
    write_joint_trajectory_yaml,
)
from oed.design.optimisers.result import Budget
from oed.design.prior_experiments import prior_information
from oed.design.problem import DesignProblem
from oed.design.status import DesignStatus, LimitStatus
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
from oed.robot import JointLimits, Robot, load_arm
from oed.robot.load import EARTH_GRAVITY
from oed.robot.packages import read_packages
from studies.design_summary import summary
from studies.interrupt import BAD_INPUT, NO_USABLE_RESULT, leave

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
        gravity: In the base frame [m/s^2]; empty for an arm that stands upright.
        packages: Folders of ROS packages, as NAME=DIR.
        margin: Share of the velocity and acceleration limits that may be used.
        scale: Speed at which the finished motion is run, as a share.
        clearance: Distance that links must keep from each other [m].
        keep_clear: Whether the motion must keep that distance, where shapes are known.
        avoid_collision: Whether it is refused where it cannot be proven to do so.
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
    gravity: tuple[float, ...] = ()
    packages: tuple[str, ...] = ()
    margin: float = 0.9
    scale: float = 1.0
    clearance: float = CLEARANCE
    keep_clear: bool = True
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
        self._check_safety()
        if self.evaluations < 1:
            raise ValueError(f"--evaluations {self.evaluations} is not a positive number")
        if self.seed < 0:
            raise ValueError(f"--seed {self.seed} is negative")
        if self.box and not np.isfinite(self.box).all():
            raise ValueError("--box: a bound is not a finite number")
        if self.box and not (self.walls[:, 0] < self.walls[:, 1]).all():
            raise ValueError("--box: each lower bound must be below its upper bound")

    def _check_safety(self) -> None:
        for name, share in (("margin", self.margin), ("scale", self.scale)):
            if not 0.0 < share <= 1.0:
                raise ValueError(f"--{name} {share:g} is not a share above 0 and up to 1")
        if not 0.0 <= self.clearance < FAR / 2:
            raise ValueError(f"--clearance {self.clearance:g} is not between 0 and {FAR / 2:g} m")
        if self.avoid_collision and not self.keep_clear:
            raise ValueError("--avoid-collision and --no-clearance contradict each other")
        if self.gravity and self.data:
            raise ValueError("--gravity: with --data, dataset.toml says it")
        if self.gravity and not np.isfinite(self.gravity).all():
            raise ValueError("--gravity: a component is not a finite number")

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
    """A design, what was assumed, what it is worth and what the geometry says of it.

    Attributes:
        design: The motion.
        limits: Of the robot, of which the motion uses a share.
        notes: What was assumed or left out.
        efficiency: What it is worth against a bound; None where that is not known.
        clearance: What the geometry says of it.
        before: J_k and J_d of the best motion found that need not keep clear, at the same speed;
            None where that one was clear, or nothing had to be.
    """

    design: Design
    limits: JointLimits
    notes: tuple[str, ...]
    efficiency: DEfficiency | None
    clearance: ClearanceCheck
    before: dict[str, float] | None


def run(config: Config) -> Result:
    """Design a motion."""
    robot, held = hold_still_joints(_robot(config))
    robot, assumed = with_default_limits(robot.with_packages(read_packages(config.packages)))
    limits = robot.limits
    robot = robot.with_limits(limits.slower(config.margin))
    notes = [*robot.notes, *held, *assumed, *([ROTORS] if config.model == "standard" else [])]
    rng = np.random.default_rng(config.seed)
    surroundings, unchecked = _surroundings(robot, config)
    posed = default_problem(build_model(config.model, robot), config.problem)
    problem = posed.problem
    notes += posed.notes
    if config.prior:
        problem = _with_prior(problem, config.prior)
    kept = _kept(surroundings, robot, config)
    search = search_clear(problem, kept, Budget(config.evaluations, config.budget), rng)
    found = search.found
    if found.cpu_s >= config.budget:
        notes.append(
            f"stopped by --budget {config.budget:g} CPU s after {found.evaluations} of "
            f"{config.evaluations} evaluations: the same seed may give another motion"
        )
    problem = problem.slower(config.scale)
    design = Design.from_result(
        problem, found, optimiser="interior_point", seed=config.seed, others=posed.others
    )
    _check_information(design)
    clearance = (
        ClearanceCheck.not_made(unchecked)
        if surroundings is None
        else prove_clearance(surroundings, problem.trajectory, design.z)
    )
    design = dataclasses.replace(design, status=_status(design, clearance, config))
    efficiency = None
    try:
        efficiency = d_efficiency(design, rng, QUICK if config.quick_bound else None)
    except NoBound as error:
        notes.append(f"D-efficiency not known: {error}")
    before = None if search.free is None else problem.worth(search.free)
    return Result(design, limits, tuple(notes), efficiency, clearance, before)


def _kept(surroundings: Surroundings | None, robot: Robot, config: Config) -> Surroundings | None:
    """What the motion must keep clear of; None where there is nothing."""
    has_shapes = surroundings is not None and surroundings.has_shapes
    if config.avoid_collision and not has_shapes:
        reason = "it has no file" if surroundings is None else surroundings.note
        raise RobotError(f"--avoid-collision: {reason}")
    if surroundings is None:
        if config.box:
            raise RobotError(f"--box: {robot.name} does not come from a file: it has no geometry")
        return None
    if config.keep_clear:
        return surroundings if has_shapes or config.box else None
    return Surroundings(robot, config.walls, walls_only=True) if config.box else None


def _status(design: Design, clearance: ClearanceCheck, config: Config) -> DesignStatus:
    """The status with what is kept besides limits."""
    rest = LimitStatus("rest to rest", "proven" if config.problem.at_rest else "given up")
    return design.status.with_limits(
        (
            rest,
            *clearance_status(
                clearance,
                is_wanted=config.keep_clear,
                is_asked=config.avoid_collision,
                has_box=bool(config.box),
            ),
        )
    )


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
    gravity = config.gravity or EARTH_GRAVITY
    return load_arm(config.robot, joints=config.joints, gravity=gravity)


def _surroundings(robot: Robot, config: Config) -> tuple[Surroundings | None, str]:
    """What may be hit; None with the reason where the robot has no geometry."""
    clearance = config.clearance if config.keep_clear else 0.0
    try:
        return Surroundings(robot, config.walls if config.box else None, clearance), ""
    except OedError as error:
        return None, f"not checked: {error}"


def _with_prior(problem: DesignProblem, files: Sequence[str]) -> DesignProblem:
    try:
        return dataclasses.replace(problem, prior=prior_information(files, problem))
    except ValueError as error:
        raise ValueError(f"--prior {error}") from error


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
    figure = draw_motion(fine, robot.joint_names, result.limits, design.certificate, torque)
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
    more |= {"margin": config.margin, "scale": config.scale, "before_clearance": result.before}
    more |= {"robot_limits": limits_record(result.limits), "gravity": robot.gravity.tolist()}
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
    parser.add_argument(
        "--periodic", action="store_true", help="may start and end at speed, as the paper's do"
    )
    parser.add_argument(
        "--margin",
        type=float,
        default=Config.margin,
        help="share of velocity and acceleration limits that is used",
    )
    parser.add_argument(
        "--scale", type=float, default=Config.scale, help="speed of the finished motion, a share"
    )
    parser.add_argument(
        "--gravity", nargs=3, type=float, default=(), metavar=("X", "Y", "Z"),
        help="in the base frame [m/s^2], for an arm on a wall or ceiling",
    )  # fmt: skip
    parser.add_argument("--no-torque", action="store_true", help="ignore effort limits")
    parser.add_argument(
        "--scaled-columns", action="store_true", help="for J_k, A and E: J_k_scaled and so on"
    )
    parser.add_argument("--prior", nargs="+", default=(), help="design.json of earlier experiments")
    parser.add_argument(
        "--clearance", type=float, default=Config.clearance, help="that links keep [m]"
    )
    parser.add_argument(
        "--no-clearance", action="store_true", help="links may touch; whether they do is told"
    )
    parser.add_argument(
        "--avoid-collision", action="store_true", help="refuse what cannot be proven clear"
    )
    parser.add_argument(
        "--package", nargs="+", action="extend", default=[], metavar="NAME=DIR",
        help="where a ROS package lies, should its meshes not be found",
    )  # fmt: skip
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
    told = summary(result.design, result.efficiency, result.clearance, _told(result, config, notes))
    sys.stdout.write(f"{told}\n  written to {given.out}\n")
    if result.design.status.is_usable:
        return 0
    sys.stderr.write(
        "studies.design: no motion for a controller was written: a limit is not kept (see status)\n"
    )
    return NO_USABLE_RESULT


def _told(result: Result, config: Config, notes: Sequence[str]) -> tuple[str, ...]:
    """The notes, and what safety asks and costs."""
    ends = "may start and end at speed" if not config.problem.at_rest else "rest to rest"
    asked = f"{ends}; velocity and acceleration within {config.margin:.0%} of their limits"
    if config.scale != 1.0:
        asked += f"; slowed down to {config.scale:.0%} of the speed it was designed for"
    if result.before is None:
        return (asked, *notes)
    costs = (
        f"keeping clear costs J_k {result.before['J_k']:.4g} -> {result.design.J_k:.4g}, "
        f"J_d {result.before['J_d_log10']:.2f} -> {result.design.J_d:.2f}"
    )
    return (asked, costs, *notes)


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
            at_rest=not given.periodic,
            torque=not given.no_torque,
            scaled=given.scaled_columns,
        ),
        prior=tuple(given.prior),
        gravity=tuple(given.gravity),
        packages=tuple(given.package),
        margin=given.margin,
        scale=given.scale,
        clearance=given.clearance,
        keep_clear=not given.no_clearance,
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
