"""What a catalogue of torque effects knows of each: how to build it, and its page."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.context import Context
from oed.dynamics.effects.effect import Effect, State
from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import filled
from oed.dynamics.torque_model import TorqueModel

WRIST = 3  # last joints of an arm of six or more, whose drives may share a gear
AT_AN_END = 0.05  # of a step: the best that close to the end of a stretch lies beyond it
# What an effect is attached to: a joint, a joint and another one, or the whole arm (None).
Target = int | tuple[int, int] | None


@dataclass(frozen=True)
class Shape:
    """A nonlinear parameter of an effect.

    Attributes:
        name: Symbol in words.
        unit: SI unit.
        lower: Least plausible value.
        upper: Largest plausible value.
        scale: How to space trial values, "log" or "linear"; "signed log" for sizes of either
            sign, linear below `linear_below`; "choice" for whole numbers; "formula" for the terms
            that an equation has, of which the fewest are looked for and more are tried at the
            best place of those.
        points: Number of trial values in a first scan.
        default: The value if nothing is known.
        also: Values of a first scan besides those that are evenly spaced.
        fine: Number of trial values in a second scan, where a first one misses crests; 0 for none.
        never: Whether its default, beyond its range, stands for what never happens, and is no
            parameter then.
        linear_below: Size below which a "signed log" scale is linear.
        open_below: Whether what is smaller than the least value still goes by the name.
        is_bounded: Whether its ends on a linear scale are those of what is plausible, as they are
            on a logarithmic one: else they are those of what can be, such as a share of one.
        plain: Whether the default is the plain formula, which holds where the data do not speak
            against it.
    """

    name: str
    unit: str
    lower: float
    upper: float
    scale: Literal["log", "signed log", "linear", "choice", "formula"]
    points: int
    default: float
    also: tuple[float, ...] = ()
    fine: int = 0
    never: bool = False
    linear_below: float = 0.0
    open_below: bool = False
    is_bounded: bool = False
    plain: bool = False

    def __post_init__(self) -> None:
        if not self.never and not self.lower <= self.default <= self.upper:
            raise ValueError(f"{self.name}: {self.default=} outside {self.lower} to {self.upper}")
        if self.scale == "log" and self.lower <= 0:
            raise ValueError(f"{self.name}: {self.lower=} on a logarithmic scale")
        if self.scale == "signed log" and self.linear_below <= 0:
            raise ValueError(f"{self.name}: {self.linear_below=} of a logarithmic scale with signs")

    @property
    def is_estimated(self) -> bool:
        """Whether it has a deviation: it is no whole number."""
        return self.scale not in ("choice", "formula")

    def is_idle(self, value: float) -> bool:
        """Whether it stands for what never happens."""
        return self.never and value > self.upper

    def is_plain(self, value: float) -> bool:
        """Whether it is idle in the plain formula."""
        return self.plain and value == self.default

    @property
    def step(self) -> float:
        """Of its places, over which a fit of it looks around."""
        return 1.0 / max(self.points - 1, self.fine, 4)

    def past(self, value: float) -> tuple[float, float] | None:
        """Places from the end at which a value lies to a step outside; None where there are none.

        There are none where no value can be, or where it would still go by the name.
        """
        unbounded = not self.is_bounded and self.scale not in ("log", "signed log")
        if unbounded or self.is_plain(value):
            return None
        place = self.place_of(value)
        if abs(place - 1.0) < AT_AN_END * self.step:
            return 1.0, 1.0 + self.step
        if abs(place) < AT_AN_END * self.step and not self.open_below:
            return -self.step, 0.0
        return None

    @property
    def grid(self) -> tuple[float, ...]:
        """The values of a first scan; the default alone if it has one point, beside `also`."""
        if self.scale == "formula" or self.points == 1:
            return (self.default, *self.also)
        places = np.linspace(0.0, 1.0, self.points)
        return (*(self.at(float(place)) for place in places), *self.also)

    def at(self, place: float) -> float:
        """The value at a place from 0, its lower bound, to 1; places outside are brought to it."""
        value = self.outside(min(max(place, 0.0), 1.0))
        return value if self.is_estimated else float(round(value))

    def outside(self, place: float) -> float:
        """The value at any place, whether it is plausible or not."""
        if self.scale == "log":
            return float(self.lower * (self.upper / self.lower) ** place)
        if self.scale == "signed log":
            first, last = np.arcsinh(np.array([self.lower, self.upper]) / self.linear_below)
            return float(self.linear_below * np.sinh(first + place * (last - first)))
        return float(self.lower + place * (self.upper - self.lower))

    def place_of(self, value: float) -> float:
        """Where a value lies from 0, the lower bound, to 1, the upper one."""
        if self.upper <= self.lower:
            return 0.0
        if self.scale == "log":
            return float(np.log(value / self.lower) / np.log(self.upper / self.lower))
        if self.scale == "signed log":
            bounds = np.array([self.lower, value, self.upper])
            first, there, last = np.arcsinh(bounds / self.linear_below)
            return float((there - first) / (last - first))
        return float((value - self.lower) / (self.upper - self.lower))

    def slope_at(self, value: float) -> float:
        """Change of the value for a unit step of its place."""
        if self.scale == "log":
            return float(value * np.log(self.upper / self.lower))
        if self.scale == "signed log":
            first, last = np.arcsinh(np.array([self.lower, self.upper]) / self.linear_below)
            return float(np.hypot(self.linear_below, value) * (last - first))
        return float(self.upper - self.lower)


@dataclass(frozen=True)
class EffectPage:
    """The page that a reader of a diagnosis wants beside a name.

    Attributes:
        equation: Torque of the effect; s is the sign of the joint's velocity.
        source: Publication that the equation is taken from.
        parameters: What the parameters are, and what sizes are usual.
        signature: What it leaves in a residual.
        confused_with: Names of effects that look alike on poor motions.
        exposed_by: The motion that tells it from them.
    """

    equation: str
    source: str
    parameters: str
    signature: str
    confused_with: tuple[str, ...]
    exposed_by: str


Build = Callable[[Context, Target, tuple[float, ...]], Effect]
Narrow = Callable[[Context, Target, tuple[Shape, ...]], tuple[Shape, ...]]
Further = Callable[[Context], Iterable[tuple[float, ...]]]
Check = Callable[[Context, Target, tuple[float, ...], Float[ndarray, " columns"]], str | None]
SizeIn = Callable[[TorqueModel, TorqueModel], Float[ndarray, " columns"]]
Install = Callable[[Context, Target, tuple[float, ...], Float[ndarray, " columns"]], TorqueModel]


def by_its_shapes(
    _context: Context,
    _target: Target,
    _values: tuple[float, ...],
    _estimates: Float[ndarray, " columns"],
) -> None:
    """Any size is plausible, as long as its shapes lie in their ranges."""


def _as_they_are(
    _context: Context, _target: Target, shapes: tuple[Shape, ...]
) -> tuple[Shape, ...]:
    return shapes


@dataclass(frozen=True)
class CatalogueEntry:
    """An effect of the catalogue.

    Attributes:
        name: The interface name.
        scope: Whether it belongs to a joint, to the whole arm or to a pair of joints.
        shapes: Nonlinear parameters with plausible ranges, wide enough for any arm.
        build: The effect as regressor columns, for a target and values of the shapes.
        plausible: None, or why estimates of the columns' coefficients cannot be right.
        page: What to tell about it.
        between_repetitions: Whether it makes repetitions differ.
        unit_coefficient: Whether its one coefficient is 1 by construction: the size is in
            the shapes, and a free coefficient would confound it with others.
        equivalent: Names that no motion tells from this one, and why.
        holds: Names of effects that are this one with parameters left out: no motion speaks for
            them against it, and the plainer one stands until the other is needed.
        narrow: Ranges of the shapes for an arm and its data.
        beside_grid: Further shapes of a first scan; None for none.
        install: The model with the effect in its exact form; None if the columns are exact.
        size_in: Of what was installed in a model in several steps, from a base model on; None where
            steps add up.
        sets_apart: Whether an arm shows it as something of its own; None where any does.
    """

    name: str
    scope: Literal["joint", "arm", "pair"]
    shapes: tuple[Shape, ...]
    build: Build
    plausible: Check
    page: EffectPage
    between_repetitions: bool = False
    unit_coefficient: bool = False
    equivalent: tuple[str, ...] = ()
    holds: tuple[str, ...] = ()
    narrow: Narrow = _as_they_are
    beside_grid: Further | None = None
    install: Install | None = None
    size_in: SizeIn | None = None
    sets_apart: Callable[[Context], bool] | None = None

    def targets(self, context: Context) -> tuple[Target, ...]:
        """All targets on an arm: joints, ordered pairs of neighbours or within a wrist, or the arm."""
        joints = range(context.n)
        if self.sets_apart is not None and not self.sets_apart(context):
            return ()
        if self.scope == "arm":
            return (None,)
        if self.scope == "joint":
            return tuple(joints)
        wrist = range(context.n - WRIST, context.n) if context.n >= 2 * WRIST else range(0)
        return tuple(
            (i, j)
            for i in joints
            for j in joints
            if abs(i - j) == 1 or (i != j and i in wrist and j in wrist)
        )

    def further(self, context: Context) -> tuple[tuple[float, ...], ...]:
        """Shapes of a first scan besides the grid."""
        return () if self.beside_grid is None else tuple(self.beside_grid(context))

    def shapes_for(self, context: Context, target: Target) -> tuple[Shape, ...]:
        """The nonlinear parameters with ranges that the data at hand can tell apart."""
        return self.narrow(context, target, self.shapes)

    def apply(
        self,
        context: Context,
        target: Target,
        values: tuple[float, ...],
        estimates: Float[ndarray, " columns"],
    ) -> TorqueModel:
        """The context's model with the effect in it, exactly where columns are a first order.

        Args:
            context: Its model is extended.
            target: What the effect is attached to.
            values: Of the shapes.
            estimates: Of the coefficients of the columns of `build`.
        """
        if self.install is not None:
            return self.install(context, target, values, estimates)
        return context.model.with_effects(self.build(context, target, values))


def evaluate(
    effect: Effect, motion: Motion, joints: int
) -> Float[ndarray, "samples joints columns"]:
    """The columns of one effect over a motion of that many joints."""
    return filled(effect.entries(State.along(motion)), len(motion), joints)
