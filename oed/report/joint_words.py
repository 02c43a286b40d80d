"""What joints, their coordinates and their units are called where people read of them."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.robot.robot import Joint

COORDINATES = {
    "q": ("position", "rad"),
    "dq": ("velocity", "rad/s"),
    "ddq": ("acceleration", "rad/s²"),
    "tau": ("torque", "N m"),
    "temperature": ("temperature", "°C"),
}


def joint_labels(names: Sequence[str]) -> list[str]:
    """Number from 1 of each joint, such as "joint 2", and its name unless that ends in the number."""
    return [
        f"joint {number}" + ("" if _last_number(name) == number else f" ({name})")
        for number, name in enumerate(names, start=1)
    ]


def place_words(joint: int | None) -> str:
    """Where an effect sits, such as "joint 2"; "arm" for the whole of it."""
    return "arm" if joint is None else f"joint {joint + 1}"


def torque_units(joints: Sequence[Joint]) -> list[str]:
    """Unit of each joint's torque or force."""
    return [joint.unit("N m") for joint in joints]


def torque_label(joints: Sequence[Joint], quantity: str = "torque") -> str:
    """A quantity of torque with its unit, or with both where some joints are prismatic."""
    units = dict.fromkeys(torque_units(joints))
    if "A" in units:
        return f"{quantity.replace('torque', 'current')} [A]"
    if "N" not in units:
        return f"{quantity} [N m]"
    force = quantity.replace("torque", "force")
    return f"{force} [N]" if len(units) == 1 else f"{quantity} [N m; N at prismatic joints]"


def coordinate_label(coordinate: str, joints: Sequence[Joint]) -> str:
    """Such as "velocity of joint 2 [rad/s]" of "dq_2"; "time [s]" of "time"."""
    kind, _, number = coordinate.partition("_")
    if kind not in COORDINATES:
        return f"{coordinate} [s]"
    quantity, unit = COORDINATES[kind]
    return f"{quantity} of joint {number} [{joints[int(number) - 1].unit(unit)}]"


def over_floor(errors: Float[ndarray, " joints"], floor: Float[ndarray, " joints"]) -> float:
    """Errors of joints whose units may differ, as one number: root mean square in noise floors."""
    return float(np.sqrt(np.mean((errors / floor) ** 2)))


def _last_number(name: str) -> int | None:
    digits = re.search(r"[0-9]+$", name)
    return int(digits.group()) if digits else None
