"""Which class of motions goes by which name; users add their own.

A class is made for a robot's limits by a function, which is registered by `trajectory_class`, or found
in the entry points of installed packages under `oed.trajectories`, whose modules do the same.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from typing import TypeVar

from oed.design.trajectories.fourier import FourierClass
from oed.design.trajectories.harmonic import HarmonicClass
from oed.design.trajectories.trajectory import TrajectoryClass
from oed.robot import JointLimits

ENTRY_POINTS = "oed.trajectories"
RAMP = 0.1  # share of the horizon over which sums of sines rise from rest, and return to it


@dataclass(frozen=True)
class Wishes:
    """What a class of motions is made for.

    Attributes:
        limits: Of the robot, finite in position.
        horizon: Length of the motion [s].
        terms: Harmonics, or sines, a joint.
        at_rest: Whether motions start and end at rest.
    """

    limits: JointLimits
    horizon: float
    terms: int
    at_rest: bool


Make = Callable[[Wishes], TrajectoryClass]
Given = TypeVar("Given", bound=Make)
_makers: dict[str, Make] = {}


def trajectory_class(name: str) -> Callable[[Given], Given]:
    """Register how a class is made, under a name that commands accept; a later one replaces."""
    if not name.strip():
        raise ValueError("a class of trajectories needs a name")

    def register(make: Given) -> Given:
        _makers[name] = make
        return make

    return register


def known_trajectories() -> tuple[str, ...]:
    """Names that can be asked for."""
    _load_entry_points()
    return tuple(_makers)


def make_trajectory(name: str, wishes: Wishes) -> TrajectoryClass:
    """The class of a name, for a robot's limits.

    Raises:
        ValueError: If there is none of that name.
    """
    if name not in known_trajectories():
        raise ValueError(
            f"no class of trajectories {name!r}; known are {', '.join(known_trajectories())}"
        )
    return _makers[name](wishes)


@trajectory_class(FourierClass.name)
def _fourier(wishes: Wishes) -> FourierClass:
    return FourierClass(wishes.horizon, wishes.limits, wishes.terms, wishes.at_rest)


@trajectory_class(HarmonicClass.name)
def _harmonic(wishes: Wishes) -> HarmonicClass:
    ramp = RAMP * wishes.horizon if wishes.at_rest else 0.0
    return HarmonicClass.exact(wishes.limits, wishes.horizon, wishes.terms, ramp=ramp)


@cache
def _load_entry_points() -> None:
    for point in entry_points(group=ENTRY_POINTS):
        point.load()
