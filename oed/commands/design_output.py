"""What `oed design` leaves: a motion for a controller, its record and page."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oed.commands.configurations import Design
from oed.design.bound.efficiency import DEfficiency
from oed.design.clearance import ClearanceCheck
from oed.design.controller_files import files_for
from oed.design.design import Design as FoundDesign
from oed.design.design_file import design_record, limits_record
from oed.design.export import SetPoints
from oed.design.robust_worth import RobustWorth
from oed.report.design_page import design_page
from oed.report.json_file import write_json
from oed.report.motion_recording import frame_times, record_motion
from oed.report.page import write_page
from oed.report.provenance import KEY_PACKAGES, Provenance, package_versions
from oed.report.replay import Replay
from oed.robot import JointLimits

FINE = 1000  # instants of a plot
SMOKE_EVALUATIONS = 100  # a second on two joints


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
        doubt: The motion and that for the nominal model, under drawn ones; None where none were.
    """

    design: FoundDesign
    limits: JointLimits
    notes: tuple[str, ...]
    efficiency: DEfficiency | None
    clearance: ClearanceCheck
    before: dict[str, float] | None
    doubt: RobustWorth | None = None


def evaluations_of(config: Design) -> int:
    """Evaluations of the criterion that a command asks for."""
    return min(config.evaluations, SMOKE_EVALUATIONS) if config.smoke else config.evaluations


def write(result: Result, config: Design, out: Path) -> tuple[str, ...]:
    """Write motion files, `design.json`, provenance and the page; all notes.

    Nothing that a controller could run where the motion is not usable.
    """
    design = result.design
    robot = design.problem.model.robot
    if design.status.is_usable:
        _write_for_controller(design, config, out)
    recorded = record_motion(robot, design.motion(frame_times(design.horizon)))
    notes = (*result.notes, *((recorded.note,) if recorded.note else ()))
    record = design_record(
        design,
        versions=package_versions(KEY_PACKAGES),
        d_efficiency=None if result.efficiency is None else dataclasses.asdict(result.efficiency),
        notes=notes,
    )
    more: dict[str, object] = {"evaluations_asked": evaluations_of(config)}
    more |= {"margin": config.margin, "scale": config.scale, "before_clearance": result.before}
    more |= {"robot_limits": limits_record(result.limits), "gravity": robot.gravity.tolist()}
    more |= {"model": str(config.model), "prior": list(config.prior), "clearance": result.clearance}
    more |= {"robust": result.doubt}
    write_json(out / "design.json", {**record, **more})
    provenance = Provenance.collect(config, seed=config.seed)
    provenance.write(out / "provenance.json")
    _write_page(result, told_of(result, config, notes), provenance, recorded.replay, out)
    return notes


def _write_page(
    result: Result, told: Sequence[str], provenance: Provenance, replay: Replay | None, out: Path
) -> None:
    design = result.design
    fine = design.motion(np.linspace(0.0, design.horizon, FINE))
    nominal = design.problem.nominal
    page = design_page(
        design, result.limits, result.efficiency, result.clearance,
        notes=told, provenance=provenance, fine=fine,
        torque=None if nominal is None else design.problem.model.torque(nominal, fine),
        replay=replay, doubt=result.doubt,
    )  # fmt: skip
    write_page(out / "report.html", page)


def _write_for_controller(design: FoundDesign, config: Design, out: Path) -> None:
    problem = design.problem
    points = SetPoints.sample(
        problem.trajectory, design.z, problem.model.robot.joint_names, config.rate
    )
    for file in files_for(problem.model.robot):
        file.write(points, out / file.name)


def told_of(result: Result, config: Design, notes: Sequence[str]) -> tuple[str, ...]:
    """The notes, and what safety asks and changed."""
    ends = "may start and end at speed" if config.periodic else "rest to rest"
    asked = f"{ends}; velocity and acceleration within {config.margin:.0%} of their limits"
    if config.scale != 1.0:
        asked += f"; slowed down to {config.scale:.0%} of the speed it was designed for"
    if result.before is None:
        return (asked, *notes)
    return (asked, kept_clear(result.before, result.design.J_k, result.design.J_d), *notes)


def kept_clear(before: Mapping[str, float], J_k: float, J_d: float) -> str:
    """What became of the criteria when a motion was kept clear, which may be better or worse.

    Args:
        before: "J_k" and "J_d_log10" of the motion that was not.
        J_k: Of the one that is.
        J_d: Likewise.
    """
    return (
        f"the motion was changed to keep clear: J_k from {before['J_k']:.4g} to {J_k:.4g} (small is "
        f"good), J_d from {before['J_d_log10']:.2f} to {J_d:.2f} (large is good)"
    )
