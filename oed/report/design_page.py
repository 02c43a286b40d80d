"""The page of a designed motion: what it is worth, what it keeps, and how to run it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.counted import counted
from oed.design.bound.efficiency import DEfficiency
from oed.design.clearance import ClearanceCheck
from oed.design.controller_files import files_for
from oed.design.design import Design
from oed.design.limits import Certificate
from oed.design.robust_worth import RobustWorth
from oed.dynamics.motion import Motion
from oed.report.design_summary import clearance_line, efficiency_line
from oed.report.motion_charts import SIGNALS, motion_charts
from oed.report.page import Links, Page, Section, Table, Text, Verdict
from oed.report.provenance import Provenance
from oed.report.replay import Replay
from oed.report.robust_section import robust_worth
from oed.report.table import Row
from oed.robot import JointLimits, Robot

SENDING = (
    "With ROS 2, play the YAML file to the arm's trajectory controller: `ros2 topic pub --once "
    "/joint_trajectory_controller/joint_trajectory trajectory_msgs/msg/JointTrajectory "
    '"$(cat joint_trajectory.yaml)"`; the controller\'s name is that of your arm. Bring the arm to '
    "the first position slowly before, and keep a hand at the emergency stop: the proof holds for "
    "the robot's file, not for what stands around the arm."
)


def design_page(
    design: Design,
    limits: JointLimits,
    efficiency: DEfficiency | None,
    clearance: ClearanceCheck,
    *,
    notes: Sequence[str],
    provenance: Provenance,
    fine: Motion,
    torque: Float[ndarray, "samples joints"] | None,
    replay: Replay | None,
    doubt: RobustWorth | None = None,
) -> Page:
    """The whole page.

    Args:
        design: The motion.
        limits: Of the robot, of which the motion uses a share.
        efficiency: What it is worth against a bound; None where that is not known.
        clearance: What the geometry says of it.
        notes: What was assumed or left out.
        provenance: Of the run.
        fine: The motion, sampled finely.
        torque: (N, n) of the nominal model along it [N m]; None where there is none.
        replay: The arm as it moves; None where it cannot be shown.
        doubt: What it is worth under drawn models; None where none were drawn.
    """
    robot = design.problem.model.robot
    return Page(
        title=f"Excitation motion of {robot.name}",
        verdict=_verdict(design),
        sections=(
            *(() if replay is None else (Section("The motion", (replay,)),)),
            Section("What it is worth", _worth(design, efficiency)),
            *(() if doubt is None else (Section("What doubt costs", robust_worth(doubt)),)),
            Section("What it keeps", _kept(design, limits, clearance)),
            Section("Joint by joint", motion_charts(robot, limits, fine, torque)),
            Section("What is assumed", tuple(Text(f"{note}.") for note in notes)),
            Section("How to run it", _running(design)),
            Section(
                "How it was made",
                (Text(f"Commit {provenance.commit}, {provenance.date}, {provenance.cpu}."),),
            ),
        ),
    )


def _verdict(design: Design) -> Verdict:
    status = design.status
    level: Literal["good", "warning", "bad"] = (
        "bad" if not status.is_usable else "good" if status.is_proven else "warning"
    )
    headline = {
        "good": "Everything that was asked for is proven for all times.",
        "warning": "The motion may be run; not everything is proven.",
        "bad": "The motion must not be run.",
    }[level]
    return Verdict(level, headline, f"{status}.")


def _worth(design: Design, efficiency: DEfficiency | None) -> tuple[Text | Table, ...]:
    problem = design.problem
    rows: list[Row] = [
        {"": "J_k = cond Lambda", "value": design.J_k, "continuous": design.J_k_continuous},
        {"": "J_d = log10 det Lambda", "value": design.J_d, "continuous": design.J_d_continuous},
    ]
    return (
        Table(rows),
        Text(f"D-efficiency: {efficiency_line(efficiency)}."),
        Text(
            f"{counted(problem.model.robot.n, 'joint')}, "
            f"{counted(len(problem.base), 'base parameter')}, "
            f"{counted(len(problem.instants), 'instant')}; "
            f"{counted(design.evaluations, 'evaluation')} in "
            f"{design.cpu_s:.1f} s of CPU time."
        ),
    )


def _kept(
    design: Design, limits: JointLimits, clearance: ClearanceCheck
) -> tuple[Text | Table, ...]:
    status: list[Row] = [
        {"asked for": kept.limit, "standing": kept.standing, "evidence": kept.evidence or None}
        for kept in design.status.limits
    ]
    robot = design.problem.model.robot
    return (
        Table(status),
        Text(f"Nearest limit: {design.certificate.nearest}."),
        Text(f"Clearance: {clearance_line(clearance)}."),
        Table(
            _limit_rows(robot, limits, design.certificate),
            caption="Limits of the robot, what the motion is proven to stay within, and the share "
            "of the limit that this is. Of a limit that is not known the cells are empty.",
        ),
    )


def _limit_rows(robot: Robot, limits: JointLimits, certificate: Certificate) -> list[Row]:
    """A row for each joint and quantity."""
    rows: list[Row] = []
    kinds = [(kind, unit) for kind, _, unit in SIGNALS] + [("torque", "N m")]
    for j, joint in enumerate(robot.joints):
        for kind, unit in kinds:
            proven = getattr(certificate, kind)
            if proven is None:
                continue
            lower, upper = getattr(limits, kind)[j]
            low, high = proven[j]
            # A position uses its range; what has a sign, the nearer bound.
            used = (
                (high - low) / (upper - lower)
                if kind == "position"
                else max(high / upper, low / lower)
            )
            bounded = bool(np.isfinite(lower) and np.isfinite(upper))
            rows.append(
                {
                    "joint": robot.joint_names[j],
                    "quantity": f"{kind} [{joint.unit(unit)}]",
                    "lower limit": float(lower) if np.isfinite(lower) else None,
                    "proven from": float(low),
                    "proven to": float(high),
                    "upper limit": float(upper) if np.isfinite(upper) else None,
                    "used": f"{100 * used:.0f} %" if bounded else None,
                }
            )
    return rows


def _running(design: Design) -> tuple[Text | Links, ...]:
    if not design.status.is_usable:
        return (Text("No files for a controller were written: a limit is not kept."),)
    files = files_for(design.problem.model.robot)
    return (Links([(file.name, file.name, file.what) for file in files]), Text(SENDING))
