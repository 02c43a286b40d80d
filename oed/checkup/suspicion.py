"""What may be wrong with a log, one thing at a time: signs, order, gravity, units, offsets."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.checkup.trial import Trial
from oed.dynamics.motion import Motion
from oed.experiment.dataset import DataSet

Kind = Literal["sign", "position_sign", "order", "position_order", "gravity", "scale", "offset"]

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
        trial: The torque put right.
        order: (n,) whose position each joint's is taken to be.
        turn: (n,) sign that positions are multiplied by.
        gravity: (3,) in the base frame [m/s^2]; None as declared.
    """

    kind: Kind
    text: str
    remedy: str
    trial: Trial
    order: Int[ndarray, " joints"]
    turn: Float[ndarray, " joints"]
    gravity: Float[ndarray, "3"] | None = None

    @property
    def changes_motion(self) -> bool:
        """Whether positions are not as logged."""
        return bool((self.order != np.arange(len(self.order))).any() or (self.turn < 0).any())

    def motion(self, motion: Motion) -> Motion:
        """The motion put right."""
        moved = (x[:, self.order] * self.turn for x in (motion.q, motion.dq, motion.ddq))
        return Motion(motion.t, *moved)


def is_on_earth(gravity: Float[ndarray, "3"]) -> bool:
    """Whether gravity has the size that it has everywhere on Earth."""
    return abs(float(np.linalg.norm(gravity)) / STANDARD_GRAVITY - 1) <= ON_EARTH


def suspicions(dataset: DataSet) -> Iterator[Suspicion]:
    """Everything that is tried on a data set, each alone."""
    names, n = dataset.robot.joint_names, dataset.robot.n
    for j in range(n):
        yield _sign(n, (j,), names)
    for j in range(n):
        text = f"the sign of the position of {names[j]} (q_{j + 1}) is reversed"
        remedy = f"reverse q_{j + 1} (and dq_{j + 1}), or the axis in the robot's file"
        yield _suspicion(n, "position_sign", text, remedy, turn=_minus(n, (j,)))
    for i, j in itertools.combinations(range(n), 2):
        pair = f"{names[i]} and {names[j]}"
        text = f"the torques of {pair} (tau_{i + 1}, tau_{j + 1}) are exchanged"
        remedy = f"exchange the columns tau_{i + 1} and tau_{j + 1}"
        yield _suspicion(n, "order", text, remedy, trial=Trial(_exchanged(n, i, j), np.ones(n)))
        text = f"the positions of {pair} (q_{i + 1}, q_{j + 1}) are exchanged"
        remedy = f"exchange the columns q_{i + 1} and q_{j + 1} (and dq)"
        yield _suspicion(n, "position_order", text, remedy, order=_exchanged(n, i, j))
    yield from _gravities(dataset)
    yield from _scales(dataset)
    offset = Trial(np.arange(n), np.ones(n), offset=True)
    text = "the torques hold constant offsets"
    remedy = "estimate them: --model offset, or set the sensors to zero"
    yield _suspicion(n, "offset", text, remedy, trial=offset)


def signs(dataset: DataSet, joints: tuple[int, ...]) -> Suspicion:
    """The torques of some joints have the opposite sign."""
    return _sign(dataset.robot.n, joints, dataset.robot.joint_names)


def _sign(n: int, joints: tuple[int, ...], names: tuple[str, ...]) -> Suspicion:
    columns = ", ".join(f"tau_{j + 1}" for j in joints)
    which = ", ".join(names[j] for j in joints)
    text = f"the sign of the torque of {which} ({columns}) is reversed"
    trial = Trial(np.arange(n), _minus(n, joints))
    return _suspicion(n, "sign", text, f"reverse {columns}", trial=trial)


def _gravities(dataset: DataSet) -> Iterator[Suspicion]:
    declared, n = dataset.robot.gravity, dataset.robot.n
    size = float(np.linalg.norm(declared))
    strength = size or STANDARD_GRAVITY
    for axis, sign in itertools.product(range(3), (1.0, -1.0)):
        gravity = np.zeros(3)
        gravity[axis] = sign * strength
        if np.linalg.norm(gravity - declared) < 0.1 * strength:
            continue
        way = f"{'+' if sign > 0 else '-'}{AXES[axis]}"
        text = (
            f"gravity points along {way} of the base, not along {_vector(declared)} as dataset.toml "
            "declares"
        )
        yield _suspicion(
            n, "gravity", text, f"declare gravity = {_vector(gravity)}", gravity=gravity
        )
    if size > 0:
        text = f"the arm does not feel the gravity {_vector(declared)} that dataset.toml declares"
        remedy = "declare gravity = [0, 0, 0] if the arm moves in a level plane"
        yield _suspicion(n, "gravity", text, remedy, gravity=np.zeros(3))


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
    gain = np.ones(n)
    gain[joint] = factor
    remedy = f"multiply tau_{joint + 1} by {factor:g}"
    return _suspicion(n, "scale", text, remedy, trial=Trial(np.arange(n), gain))


def _suspicion(
    n: int,
    kind: Kind,
    text: str,
    remedy: str,
    *,
    trial: Trial | None = None,
    order: Int[ndarray, " joints"] | None = None,
    turn: Float[ndarray, " joints"] | None = None,
    gravity: Float[ndarray, "3"] | None = None,
) -> Suspicion:
    return Suspicion(
        kind=kind,
        text=text,
        remedy=remedy,
        trial=Trial.unchanged(n) if trial is None else trial,
        order=np.arange(n) if order is None else order,
        turn=np.ones(n) if turn is None else turn,
        gravity=gravity,
    )


def _minus(n: int, joints: tuple[int, ...]) -> Float[ndarray, " joints"]:
    sign = np.ones(n)
    sign[list(joints)] = -1.0
    return sign


def _exchanged(n: int, i: int, j: int) -> Int[ndarray, " joints"]:
    order = np.arange(n)
    order[[i, j]] = order[[j, i]]
    return order


def _vector(gravity: Float[ndarray, "3"]) -> str:
    return "[" + ", ".join(f"{x:.4g}" for x in gravity) + "]"
