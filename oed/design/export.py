"""Designs as files for controllers: CSV, ROS 2 JointTrajectory as YAML and JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.trajectories import TrajectoryClass
from oed.dynamics.motion import Motion

NANOSECONDS = 1_000_000_000
# Digits of a float64 that survive a round trip through text.
DIGITS = 17


@dataclass(frozen=True)
class SetPoints:
    """A motion at the rate of a controller.

    Attributes:
        joint_names: (n,) in the order of the columns.
        motion: Every instant from 0 to the horizon, the end included.
    """

    joint_names: tuple[str, ...]
    motion: Motion

    @classmethod
    def sample(
        cls,
        trajectory: TrajectoryClass,
        z: Float[ndarray, " size"],
        joint_names: Sequence[str],
        rate: float,
    ) -> SetPoints:
        """Sample a motion.

        Args:
            trajectory: The class.
            z: The motion.
            joint_names: (n,) names.
            rate: Samples a second [Hz]; the last sample is the end of the horizon.

        Raises:
            ValueError: If the rate is not positive, or the names are not n.
        """
        if not rate > 0:
            raise ValueError(f"{rate=} is not positive")
        if len(joint_names) != trajectory.joints:
            raise ValueError(f"{len(joint_names)} names for {trajectory.joints} joints")
        count = int(np.floor(trajectory.horizon * rate + 1e-9))
        t = np.arange(count + 1) / rate
        if t[-1] < trajectory.horizon - 1e-9:
            t = np.append(t, trajectory.horizon)
        return cls(tuple(joint_names), trajectory.motion(z, t))


def write_csv(points: SetPoints, path: str | Path) -> None:
    """Columns t, q_NAME, dq_NAME, ddq_NAME; SI units; one row an instant."""
    names = points.joint_names
    header = ["t", *(f"{signal}_{name}" for signal in ("q", "dq", "ddq") for name in names)]
    motion = points.motion
    table = np.column_stack([motion.t, motion.q, motion.dq, motion.ddq])
    np.savetxt(path, table, fmt=f"%.{DIGITS}g", delimiter=",", header=",".join(header), comments="")


def joint_trajectory(points: SetPoints) -> dict[str, object]:
    """The fields of a ROS 2 trajectory_msgs/msg/JointTrajectory."""
    motion = points.motion
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": list(points.joint_names),
        "points": [
            {
                "positions": motion.q[k].tolist(),
                "velocities": motion.dq[k].tolist(),
                "accelerations": motion.ddq[k].tolist(),
                "effort": [],
                "time_from_start": _duration(motion.t[k]),
            }
            for k in range(len(motion))
        ],
    }


def write_joint_trajectory_json(points: SetPoints, path: str | Path) -> None:
    """A JointTrajectory as JSON."""
    Path(path).write_text(json.dumps(joint_trajectory(points), indent=1) + "\n", encoding="utf-8")


def write_joint_trajectory_yaml(points: SetPoints, path: str | Path) -> None:
    """A JointTrajectory as YAML, as `ros2 topic pub` takes it.

    Lists and names are written in JSON's notation, which is YAML too.
    """
    message = joint_trajectory(points)
    lines = [
        "header: {stamp: {sec: 0, nanosec: 0}, frame_id: ''}",
        f"joint_names: {json.dumps(message['joint_names'])}",
        "points:",
    ]
    for point in message["points"]:  # type: ignore[attr-defined]  # a list by construction
        duration = point["time_from_start"]
        lines += [
            f"- positions: {json.dumps(point['positions'])}",
            f"  velocities: {json.dumps(point['velocities'])}",
            f"  accelerations: {json.dumps(point['accelerations'])}",
            "  effort: []",
            f"  time_from_start: {{sec: {duration['sec']}, nanosec: {duration['nanosec']}}}",
        ]
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def _duration(seconds: float) -> dict[str, int]:
    whole, rest = divmod(round(float(seconds) * NANOSECONDS), NANOSECONDS)
    return {"sec": whole, "nanosec": rest}
