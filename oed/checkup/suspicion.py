"""What may be wrong with a log, one thing at a time: signs, order, gravity, units."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.checkup.change import Change
from oed.experiment.dataset import DataSet

Kind = Literal["sign", "position_sign", "order", "position_order", "gravity", "scale", "factor"]

STANDARD_GRAVITY = 9.81  # [m/s^2] where none is declared
# Relative to it: from the equator to the poles gravity differs by 0.3 %.
ON_EARTH = 0.01
UNITS = {1e3: "N mm or mN m in place of N m", 1e-3: "kN m in place of N m"}
AXES = "xyz"


@dataclass(frozen=True)
class Suspicion:
    """One thing that may be wrong, and how the log would be without it.

    Attributes:
        kind: Of the fault.
        text: The fault in words, as a sentence without its full stop.
        remedy: What to do about it.
        change: That puts the log right.
    """

    kind: Kind
    text: str
    remedy: str
    change: Change


def is_on_earth(gravity: Float[ndarray, "3"]) -> bool:
    """Whether gravity has the size that it has everywhere on Earth."""
    return abs(float(np.linalg.norm(gravity)) / STANDARD_GRAVITY - 1) <= ON_EARTH


def suspicions(dataset: DataSet) -> Iterator[Suspicion]:
    """Everything that is tried on a data set, each alone."""
    names, n = dataset.robot.joint_names, dataset.robot.n
    none = Change.none(n)
    for j in range(n):
        yield signs(dataset, (j,))
    for j in range(n):
        text = f"the sign of the position of {names[j]} (q_{j + 1}) is reversed"
        remedy = f"reverse q_{j + 1} (and dq_{j + 1}), or the axis in the robot's file"
        turned = dataclasses.replace(none, turn=_minus(n, (j,)))
        yield Suspicion("position_sign", text, remedy, turned)
    for i, j in itertools.combinations(range(n), 2):
        pair, order = f"{names[i]} and {names[j]}", _exchanged(n, i, j)
        text = f"the torques of {pair} (tau_{i + 1}, tau_{j + 1}) are exchanged"
        remedy = f"exchange the columns tau_{i + 1} and tau_{j + 1}"
        yield Suspicion("order", text, remedy, dataclasses.replace(none, source=order))
        text = f"the positions of {pair} (q_{i + 1}, q_{j + 1}) are exchanged"
        remedy = f"exchange the columns q_{i + 1} and q_{j + 1} (and dq)"
        yield Suspicion("position_order", text, remedy, dataclasses.replace(none, order=order))
    yield from _gravities(dataset)
    yield from _scales(dataset)


def signs(dataset: DataSet, joints: tuple[int, ...]) -> Suspicion:
    """The torques of some joints have the opposite sign."""
    names, n = dataset.robot.joint_names, dataset.robot.n
    columns = ", ".join(f"tau_{j + 1}" for j in joints)
    which = ", ".join(names[j] for j in joints)
    text = f"the sign of the torque of {which} ({columns}) is reversed"
    change = dataclasses.replace(Change.none(n), gain=_minus(n, joints))
    return Suspicion("sign", text, f"reverse {columns}", change)


def _gravities(dataset: DataSet) -> Iterator[Suspicion]:
    """Along every axis or the other way, of the size declared or on Earth; or none."""
    declared, none = dataset.robot.gravity, Change.none(dataset.robot.n)
    size = float(np.linalg.norm(declared))
    if size > 0:
        text = f"the arm does not feel the gravity {_vector(declared)} that dataset.toml declares"
        remedy = "declare gravity = [0, 0, 0] if the arm moves in a level plane"
        change = dataclasses.replace(none, gravity=(0.0, 0.0, 0.0))
        yield Suspicion("gravity", text, remedy, change)
    ways = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    if size > 0:
        ways += [declared / size, -declared / size]
    sizes = [size] if is_on_earth(declared) else [STANDARD_GRAVITY, *([size] if size > 0 else [])]
    known = [declared]
    for strength, way in itertools.product(sizes, ways):
        gravity = strength * way
        if min(float(np.linalg.norm(gravity - other)) for other in known) < 0.1 * strength:
            continue
        known.append(gravity)
        text = (
            f"gravity is {strength:.4g} m/s^2 along {_direction(way)} of the base, not "
            f"{_vector(declared)} as dataset.toml declares"
        )
        change = dataclasses.replace(none, gravity=tuple(gravity.tolist()))
        yield Suspicion("gravity", text, f"declare gravity = {_vector(gravity)}", change)


def _scales(dataset: DataSet) -> Iterator[Suspicion]:
    names, n = dataset.robot.joint_names, dataset.robot.n
    ratios = np.ones(n) if dataset.drive.gear_ratio is None else np.abs(dataset.drive.gear_ratio)
    for j in range(n):
        if ratios[j] > 1:
            text = (
                f"the torque of {names[j]} (tau_{j + 1}) is that of the motor: 1/{ratios[j]:g} of the "
                "joint's, the gear left out"
            )
            yield _scale(n, j, float(ratios[j]), text)
        for unit, words in UNITS.items():
            yield _scale(n, j, 1 / unit, f"the torque of {names[j]} (tau_{j + 1}) is in {words}")


def _scale(n: int, joint: int, factor: float, text: str) -> Suspicion:
    remedy = f"multiply tau_{joint + 1} by {factor:g}"
    return Suspicion("scale", text, remedy, Change.of_torque(n, joint, factor))


def _minus(n: int, joints: tuple[int, ...]) -> tuple[float, ...]:
    return tuple(-1.0 if j in joints else 1.0 for j in range(n))


def _exchanged(n: int, i: int, j: int) -> tuple[int, ...]:
    order = list(range(n))
    order[i], order[j] = j, i
    return tuple(order)


def _direction(way: Float[ndarray, "3"]) -> str:
    """An axis by its name where it is one."""
    axis = int(np.abs(way).argmax())
    return f"{'+' if way[axis] > 0 else '-'}{AXES[axis]}" if abs(way[axis]) == 1 else _vector(way)


def _vector(gravity: Float[ndarray, "3"]) -> str:
    return "[" + ", ".join(f"{x + 0.0:.4g}" for x in gravity) + "]"
