"""Published base parameters, listed as "Ixx3 - 1.0*Iyy3 + …, value": a robot that has them.

The first parameter of each sum takes the whole value and all regrouped ones are zero. That robot's
torque is the table's, because a regrouping leaves the torque as it is.
"""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import rigid_body_torque
from oed.robot import Robot
from studies.public_arms.arm import Torque

LEADING = re.compile(r"\s*([A-Za-z]+)(\d+)")


def read_table(path: Path, *, first: int) -> dict[str, float]:
    """Values by name, such as "Ixx_3", with joints numbered from 1.

    Args:
        path: Lines of a sum and its value; what follows is ignored.
        first: The table's number of joint 1.

    Raises:
        ValueError: If a line is none of these.
    """
    found = {}
    with path.open(encoding="utf-8", newline="") as file:
        for number, line in enumerate(csv.reader(file), 1):
            match = LEADING.match(line[0]) if len(line) > 1 else None
            if match is None:
                raise ValueError(f"{path}, line {number}: no base parameter and its value")
            found[f"{match[1]}_{int(match[2]) - first + 1}"] = float(line[1])
    return found


def of_joints(table: dict[str, float], symbol: str, joints: int) -> Float[ndarray, " joints"]:
    """(n,) of one kind, zero where the table has none."""
    return np.array([table.get(f"{symbol}_{j + 1}", 0.0) for j in range(joints)])


def torque_of_table(robot: Robot, table: dict[str, float]) -> Torque:
    """Rigid body, rotor inertia (Ia), viscous (fv) and Coulomb (fs) friction, offset (off)."""
    own = robot.with_parameters(np.array([table.get(x, 0.0) for x in robot.parameter_names]))
    Ia, fv, fs, off = (of_joints(table, x, robot.n) for x in ("Ia", "fv", "fs", "off"))

    def torque(motion: Motion) -> Float[ndarray, "samples joints"]:
        friction = fv * motion.dq + fs * np.sign(motion.dq) + off
        return rigid_body_torque(own, motion) + Ia * motion.ddq + friction

    return torque
