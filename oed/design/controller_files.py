"""Every file in which a design goes to a controller, and the arms that can take it.

URScript: The URScript Programming Language, Universal Robots, module motion (`servoj`) and module
internals (`get_actual_joint_positions`, `popup`). libfranka: `franka::Robot::control` asks a callback
for `franka::JointPositions` every millisecond.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oed.design.export import (
    DIGITS,
    SetPoints,
    write_csv,
    write_joint_trajectory_json,
    write_joint_trajectory_yaml,
)
from oed.in_comment import in_comment
from oed.robot import Robot

UR_JOINTS, FRANKA_JOINTS = 6, 7
# What `servoj` has where nothing is given. Both smooth the motion: what runs is not quite what was
# designed, and what is recorded counts.
LOOKAHEAD = 0.1  # [s], of 0.03 to 0.2
GAIN = 300  # of 100 to 2000
NEAR = 0.01  # [rad] from the first set point, beyond which the program does not start
STOP = 2.0  # [rad/s^2] at which the arm stops at the end, where it rests already
UR_DIGITS = 9  # decimals: a thousandth of an encoder's step


@dataclass(frozen=True)
class ControllerFile:
    """A file for a controller.

    Attributes:
        name: Of the file.
        what: Is in it, for the page.
        joints: Of the arms that can take it, all revolute; None for any arm.
        write: (set points, path).
    """

    name: str
    what: str
    joints: int | None
    write: Callable[[SetPoints, str | Path], None]

    def fits(self, robot: Robot) -> bool:
        """Whether an arm can take it."""
        kinds = [joint.kind for joint in robot.joints]
        return self.joints is None or kinds == ["revolute"] * self.joints


def write_urscript(points: SetPoints, path: str | Path) -> None:
    """A program of `servoj` for an arm of Universal Robots; it starts at the first set point or not at all.

    Raises:
        ValueError: If there are not six joints.
    """
    _check_joints(points, UR_JOINTS, "URScript")
    motion = points.motion
    first, *rest = ([f"{x:.{UR_DIGITS}f}" for x in q] for q in motion.q)
    lines = [
        f"# {in_comment(', '.join(points.joint_names))}: {motion.t[-1]:g} s, radians and seconds",
        "# A step shorter than the control cycle, or no multiple of it, runs too slowly: 2 ms, or 8 ms for CB3.",
        "def oed_motion():",
        f"  start = [{', '.join(first)}]",
        "  at = get_actual_joint_positions()",
        "  i = 0",
        f"  while i < {UR_JOINTS}:",
        f"    if at[i] - start[i] > {NEAR} or at[i] - start[i] < -{NEAR}:",
        '      popup("Bring the arm to the first posture of the motion", error=True, blocking=True)',
        "      halt",
        "    end",
        "    i = i + 1",
        "  end",
        *(
            f"  servoj([{', '.join(q)}], 0, 0, {step:.{UR_DIGITS}f}, {LOOKAHEAD}, {GAIN})"
            for q, step in zip(rest, np.diff(motion.t), strict=True)
        ),
        f"  stopj({STOP})",
        "end",
    ]
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_libfranka_csv(points: SetPoints, path: str | Path) -> None:
    """Columns time [s] and q_d[0] to q_d[6] [rad], as `franka::RobotState` calls them.

    Raises:
        ValueError: If there are not seven joints.
    """
    _check_joints(points, FRANKA_JOINTS, "libfranka")
    header = ",".join(["time", *(f"q_d[{j}]" for j in range(FRANKA_JOINTS))])
    table = np.column_stack([points.motion.t, points.motion.q])
    np.savetxt(path, table, fmt=f"%.{DIGITS}g", delimiter=",", header=header, comments="")


def _check_joints(points: SetPoints, joints: int, whose: str) -> None:
    if len(points.joint_names) != joints:
        raise ValueError(f"{len(points.joint_names)} joints: {whose} moves arms of {joints}")


CONTROLLER_FILES = (
    ControllerFile(
        "motion.csv", "time, position, velocity and acceleration of every joint", None, write_csv
    ),
    ControllerFile(
        "joint_trajectory.yaml",
        "trajectory_msgs/JointTrajectory, as YAML",
        None,
        write_joint_trajectory_yaml,
    ),
    ControllerFile("joint_trajectory.json", "the same, as JSON", None, write_joint_trajectory_json),
    ControllerFile(
        "motion.script",
        "URScript, should the arm be one of Universal Robots: servoj from set point to set point; --rate 125 or 500",
        UR_JOINTS,
        write_urscript,
    ),
    ControllerFile(
        "motion_libfranka.csv",
        "time and q_d for a callback of libfranka, should the arm be one of Franka; --rate 1000",
        FRANKA_JOINTS,
        write_libfranka_csv,
    ),
)


def files_for(robot: Robot) -> tuple[ControllerFile, ...]:
    """Those that an arm can take."""
    return tuple(file for file in CONTROLLER_FILES if file.fits(robot))
