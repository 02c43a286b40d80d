"""From a robot's file to an excitation motion that provably keeps its limits.

    python -m studies.design --robot FILE|builtin:NAME --out DIR
    python -m studies.design --data DIR --out DIR

Writes the motion for a controller (CSV, ROS 2 JointTrajectory), `design.json`, the motion
against its limits, and a page in which the arm moves.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oed.design.collision import ClearanceCheck, check_clearance
from oed.design.criteria import Criterion, column_scaling
from oed.design.default_limits import with_default_limits
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
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.errors import OedError
from oed.experiment.read_dataset import read_dataset
from oed.report.design_plots import draw_motion
from oed.report.json_file import write_json
from oed.report.motion_recording import FRAMES_PER_SECOND, record_motion
from oed.report.output_folder import check_output_folder
from oed.report.provenance import KEY_PACKAGES, Provenance, package_versions
from oed.report.style import save_figure
from oed.robot import Robot, arm_joints, load_robot

CANNOT_STAND = (
    "torque is not limited: by the file's inertia the arm cannot even hold itself within its "
    "effort limits at mid-range"
)
CHECKED_INSTANTS = 400  # of the clearance check
SCALING_STARTS = 5  # random motions whose mean information gives each column its unit


@dataclass(frozen=True)
class Config:
    """What to design.

    Attributes:
        robot: File or "builtin:NAME"; empty where a data set names it.
        data: Folder of a data set; empty where `robot` is given.
        joints: Names of the joints to move; empty for the arm proper.
        horizon: Period of the motion [s].
        harmonics: Of the Fourier series.
        instants: Sampled in a period.
        criterion: "J_k", "J_d", "A" or "E".
        at_rest: Whether the motion starts and ends at rest.
        torque: Whether the file's effort limits hold for the file's own inertia.
        rate: Of the exported motion [Hz].
        budget: CPU time of the optimiser [s].
        seed: Of starts and hops.
    """

    robot: str = ""
    data: str = ""
    joints: tuple[str, ...] = ()
    horizon: float = 10.0
    harmonics: int = 5
    instants: int = 200
    criterion: Criterion = "J_d"
    at_rest: bool = False
    torque: bool = True
    rate: float = 100.0
    budget: float = 15.0
    seed: int = 0


@dataclass(frozen=True)
class Result:
    """A design, what was assumed, and what the geometry says of it."""

    design: Design
    notes: tuple[str, ...]
    clearance: ClearanceCheck


def run(config: Config) -> Result:
    """Design a motion."""
    robot, notes = with_default_limits(_robot(config))
    rng = np.random.default_rng(config.seed)
    problem, more = build_problem(robot, config, rng)
    found = optimise(problem, Budget(cpu_seconds=config.budget), rng)
    design = Design.from_result(problem, found, optimiser="interior_point", seed=config.seed)
    seen = design.motion(np.linspace(0.0, config.horizon, CHECKED_INSTANTS))
    return Result(design, notes + more, check_clearance(robot, seen))


def build_problem(
    robot: Robot, config: Config, rng: np.random.Generator
) -> tuple[DesignProblem, tuple[str, ...]]:
    """The problem of a robot with finite limits, and notes on what was left out."""
    model = TorqueModel.standard(robot)
    base = base_parameters(model)
    trajectory = FourierClass(config.horizon, robot.limits, config.harmonics, config.at_rest)
    nominal, notes = _nominal(robot, model, enabled=config.torque)
    problem = DesignProblem(
        model,
        base,
        trajectory,
        robot.limits,
        trajectory.instants(config.instants),
        config.criterion,
        nominal=nominal,
    )
    starts = [problem.random_start(rng) for _ in range(SCALING_STARTS)]
    typical = np.mean([problem.information(z) for z in starts], axis=0)
    scaled = dataclasses.replace(problem, scaling=column_scaling(typical))
    return scaled, (*notes, *((base.note,) if base.note else ()))


def _nominal(
    robot: Robot, model: TorqueModel, *, enabled: bool
) -> tuple[np.ndarray | None, tuple[str, ...]]:
    """The file's own inertia without friction, where it can be held against effort limits."""
    limited = np.isfinite(robot.limits.torque).any()
    if not enabled or not limited or not np.any(robot.parameters):
        return None, ("torque is not limited",)
    nominal = np.zeros(len(model.parameters))
    nominal[: len(robot.parameters)] = robot.parameters
    standing = model.torque(nominal, _still(robot))[0]
    if (np.abs(standing) > 0.9 * np.abs(robot.limits.torque).min(axis=1)).any():
        return None, (CANNOT_STAND,)
    return nominal, ("torque is limited for the file's own inertia, friction not counted",)


def _still(robot: Robot) -> Motion:
    middle = robot.limits.position.mean(axis=1)[None]
    return Motion(np.zeros(1), middle, np.zeros_like(middle), np.zeros_like(middle))


def _robot(config: Config) -> Robot:
    if config.data:
        return read_dataset(config.data, joints=config.joints or None).robot
    return load_robot(config.robot, joints=config.joints or arm_joints(config.robot))


def write(result: Result, config: Config, out: Path) -> None:
    """Write motion files, `design.json`, plot, recording and provenance."""
    out.mkdir(parents=True, exist_ok=True)
    design = result.design
    robot = design.problem.model.robot
    points = SetPoints.sample(design.problem.trajectory, design.z, robot.joint_names, config.rate)
    write_csv(points, out / "motion.csv")
    write_joint_trajectory_yaml(points, out / "joint_trajectory.yaml")
    write_joint_trajectory_json(points, out / "joint_trajectory.json")
    fine = design.motion(np.linspace(0.0, design.horizon, 1000))
    nominal = design.problem.nominal
    torque = None if nominal is None else design.problem.model.torque(nominal, fine)
    figure = draw_motion(fine, robot.joint_names, robot.limits, design.certificate, torque)
    save_figure(figure, out / "motion", formats=("png",))
    frames = design.motion(np.arange(0.0, design.horizon, 1 / FRAMES_PER_SECOND))
    note = record_motion(robot, frames, out / "motion.html")
    notes = (*result.notes, *((note,) if note else ()))
    record = design_record(design, versions=package_versions(KEY_PACKAGES), notes=notes)
    write_json(out / "design.json", {**record, "clearance": result.clearance})
    Provenance.collect(config, seed=config.seed).write(out / "provenance.json")


def summary(result: Result) -> str:
    """A few lines for the screen."""
    design, clearance = result.design, result.clearance
    problem = design.problem
    sampled = f"J_k = cond Lambda  {design.J_k:.4g}"
    elsewhere = f"continuous {design.J_k_continuous:.4g}; scaled columns {design.J_k_scaled:.4g}"
    size = f"{problem.model.robot.n} joints, {len(problem.base)} base parameters"
    rows = f"{len(problem.instants)} instants, {problem.rows} rows"
    spare = -design.certificate.violation
    lines = [
        f"{problem.model.robot.name}: {size}, {rows}",
        f"  status  {design.status}",
        f"  {sampled} ({elsewhere})",
        f"  J_d = log10 det Lambda  {design.J_d:.4f} (continuous {design.J_d_continuous:.4f})",
        f"  nearest limit  {design.certificate.worst}, proven {spare:.2e} of it to spare",
        f"  self-collision  {_clearance_line(clearance)}",
        f"  {design.evaluations} evaluations in {design.cpu_s:.1f} s of CPU time",
    ]
    return "\n".join(lines + [f"  note: {note}" for note in result.notes])


def _clearance_line(clearance: ClearanceCheck) -> str:
    if clearance.deepest is None:
        return clearance.note
    if clearance.deepest == 0.0:
        return f"none at {clearance.instants} instants {clearance.note}"
    return (
        f"{clearance.pair} overlap by {clearance.deepest * 1e3:.1f} mm at {clearance.time:.2f} s; "
        f"narrow the limits {clearance.note}"
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Run from the command line; 0 if all went well, 2 if the input cannot be used."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--robot", default="", help="URDF, SDF or MJCF file, or builtin:NAME")
    source.add_argument("--data", default="", help="folder of a data set")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--joints", nargs="+", default=())
    parser.add_argument("--horizon", type=float, default=Config.horizon, help="[s]")
    parser.add_argument("--criterion", choices=("J_k", "J_d", "A", "E"), default=Config.criterion)
    parser.add_argument("--at-rest", action="store_true")
    parser.add_argument("--no-torque", action="store_true", help="ignore effort limits")
    parser.add_argument("--rate", type=float, default=Config.rate, help="[Hz]")
    parser.add_argument("--seed", type=int, default=Config.seed)
    parser.add_argument("--budget", type=float, default=Config.budget, help="CPU seconds")
    parser.add_argument("--smoke", action="store_true", help="a few seconds, to see it work")
    given = parser.parse_args(argv)
    config = Config(
        robot=given.robot,
        data=given.data,
        joints=tuple(given.joints),
        horizon=given.horizon,
        instants=40 if given.smoke else Config.instants,
        criterion=given.criterion,
        at_rest=given.at_rest,
        torque=not given.no_torque,
        rate=given.rate,
        budget=1.0 if given.smoke else given.budget,
        seed=given.seed,
    )
    try:
        check_output_folder(given.out)
        result = run(config)
        write(result, config, given.out)
    except (OedError, ValueError, OSError) as error:
        sys.stderr.write(f"studies.design: {error}\n")
        return 2
    sys.stdout.write(f"{summary(result)}\n  written to {given.out}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
