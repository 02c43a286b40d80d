"""Whether limits and torques are in one unit with the limits of the robot's file."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.errors import DataSetError
from oed.robot import Robot

# A data set may know better than the robot's file, but not by this: degrees are 57 times as large.
OTHER_UNIT = 20.0
# No drive can give it on average; N mm are a thousand times too large.
IMPOSSIBLE_RMS = 10.0
IMPOSSIBLE_SAMPLE = 3.0  # a drive's peak torque is two to three times what it may give for long
FEW = 0.01  # share of a recording's samples, or `FEW_SAMPLES`, up to which they are outliers
FEW_SAMPLES = 10


def check_limits(stated: Mapping[str, Float[ndarray, "joints 2"]], robot: Robot, file: str) -> None:
    """Refuse position limits so far beyond those of the robot's file that they are in degrees.

    Args:
        stated: Limits (n, 2) of the data set by kind.
        robot: With the limits of its own file.
        file: For the message.

    Raises:
        DataSetError: Naming the joint.
    """
    if "position" not in stated:
        return
    largest = np.abs(stated["position"]).max(axis=1)
    own = np.abs(robot.limits.position).max(axis=1)
    for j in np.flatnonzero(np.isfinite(largest) & (largest > OTHER_UNIT * own)):
        is_turning = robot.joints[j].kind == "revolute"
        message = (
            f"{largest[j]:.4g} of joint {robot.joints[j].name!r} is {largest[j] / own[j]:.3g} times "
            f"the limit in the robot's file, {own[j]:.4g} {'rad' if is_turning else 'm'}: this looks "
            f"like {'degrees; convert it to radians' if is_turning else 'mm; convert it to metres'}"
        )
        raise DataSetError(message, file=file, column="limits.position")


def torque_notes(
    tau: Float[ndarray, "samples joints"],
    robot: Robot,
    file: str,
    lines: Int[ndarray, " samples"],
    *,
    is_bare_current: bool,
) -> tuple[str, ...]:
    """Refuse torque in another unit; say where single samples are beyond what a drive can give.

    Args:
        tau: (N, n) of all joints [N m or N].
        robot: With the limits that hold.
        file: For the message.
        lines: (N,) line of the file that each sample is of.
        is_bare_current: Whether these are currents without `current_to_torque`.

    Returns:
        One line a joint.

    Raises:
        DataSetError: If the rms of a joint's torque is beyond `IMPOSSIBLE_RMS` times its limit:
            naming the largest sample where few make it so, such as a sensor's mark of a lost value.
    """
    notes = []
    limit = np.abs(robot.limits.torque).max(axis=1)
    rms = np.sqrt(np.mean(tau**2, axis=0))
    cause = (
        "currents without [drive] current_to_torque, or in mA?"
        if is_bare_current
        else "mN m or N mm, or a current without [drive] current_to_torque?"
    )
    for j, joint in enumerate(robot.joints):
        named = f"the limit of joint {joint.name!r}, {limit[j]:.4g} {joint.unit('N m')}"
        size = np.abs(tau[:, j])
        row = int(size.argmax())
        count = int(np.sum(size > IMPOSSIBLE_SAMPLE * limit[j]))
        is_few = count <= max(FEW * len(tau), FEW_SAMPLES)
        beyond = (
            f"|tau| = {size[row]:.4g} is {size[row] / limit[j]:.3g} times {named}; {count} of "
            f"{len(tau)} samples are beyond {IMPOSSIBLE_SAMPLE:g} times the limit"
        )
        if rms[j] >= IMPOSSIBLE_RMS * limit[j]:
            if is_few:
                message = f"{beyond}: no torque, but a faulty value; repair the log"
                raise DataSetError(message, file=file, row=int(lines[row]), column=f"tau_{j + 1}")
            message = (
                f"rms of {rms[j]:.4g} is {rms[j] / limit[j]:.3g} times {named}: {cause} Convert it, "
                "or state [limits] torque in dataset.toml if the robot's file is wrong"
            )
            raise DataSetError(message, file=file, column=f"tau_{j + 1}")
        if count:
            why = (
                "outliers distort estimates and noise floor, remove them from the log"
                if is_few
                else "too many for outliers: the unit of tau or the limit in the robot's file is "
                "wrong; state [limits] torque in dataset.toml if it is the limit"
            )
            notes.append(f"{file}, row {lines[row]}, column 'tau_{j + 1}': {beyond}: {why}")
    return tuple(notes)
