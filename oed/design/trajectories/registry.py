"""Which class of motions goes by which name; users add their own.

A class is made for a robot's limits by a function, which is registered by `trajectory_class`, or found
in the entry points of installed packages under `oed.trajectories`, whose modules do the same. A new
family of functions is registered by `readable` too, so that its design files can be read.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeVar

from jaxtyping import Float
from numpy import ndarray

from oed.design.trajectories.fourier import FourierClass
from oed.design.trajectories.harmonic import HarmonicClass
from oed.design.trajectories.spline import SplineClass
from oed.design.trajectories.trajectory import TrajectoryClass
from oed.errors import one_line
from oed.registered import Registered
from oed.robot import JointLimits

SEGMENTS = 8  # of a spline for every harmonic that a series would have
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
CLASSES = Registered[Make]("class of trajectories", "oed.trajectories")
Family = TypeVar("Family", bound=type[TrajectoryClass])
_families: dict[str, type[TrajectoryClass]] = {}


def trajectory_class(name: str) -> Callable[[Given], Given]:
    """Register how a class is made, under a name that commands accept; a later one replaces."""
    return CLASSES.add(name)


def readable(family: Family) -> Family:
    """Register a family of functions by its name in design files; a later one replaces."""
    _families[family.name] = family
    return family


def restore_motion(
    name: str, horizon: float, limits: JointLimits, coefficients: Mapping[str, ndarray]
) -> tuple[TrajectoryClass, Float[ndarray, " size"]]:
    """The class and the motion that a design file describes.

    Args:
        name: Of the family of functions.
        horizon: [s]
        limits: Of the robot that moves.
        coefficients: By name, as `TrajectoryClass.describe` gave them.

    Raises:
        ValueError: If no family has the name, or these are not its coefficients.
    """
    CLASSES.names()  # packages add families with their classes
    if not isinstance(name, str) or name not in _families:
        known = ", ".join(_families)
        raise ValueError(f"a motion of class {one_line(repr(name))}; known are {known}")
    return _families[name].restore(horizon, limits, coefficients)


def make_trajectory(name: str, wishes: Wishes) -> TrajectoryClass:
    """The class of a name, for a robot's limits.

    Raises:
        ValueError: If there is none of that name.
    """
    return CLASSES.find(name)(wishes)


for _family in (FourierClass, HarmonicClass, SplineClass):
    readable(_family)


@trajectory_class(FourierClass.name)
def _fourier(wishes: Wishes) -> FourierClass:
    return FourierClass(wishes.horizon, wishes.limits, wishes.terms, wishes.at_rest)


@trajectory_class(HarmonicClass.name)
def _harmonic(wishes: Wishes) -> HarmonicClass:
    ramp = RAMP * wishes.horizon if wishes.at_rest else 0.0
    return HarmonicClass.exact(wishes.limits, wishes.horizon, wishes.terms, ramp=ramp)


@trajectory_class("collocation")
def _collocation(wishes: Wishes) -> SplineClass:
    segments = SEGMENTS * wishes.terms
    return SplineClass(wishes.horizon, wishes.limits, segments, 3, wishes.at_rest)


@trajectory_class(SplineClass.name)
def _spline(wishes: Wishes) -> SplineClass:
    segments = SEGMENTS * wishes.terms
    return SplineClass(wishes.horizon, wishes.limits, segments, 5, wishes.at_rest)
