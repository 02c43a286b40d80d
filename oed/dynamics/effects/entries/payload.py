"""A load that comes, and perhaps goes."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.base_parameters import find_base_parameters
from oed.dynamics.effects.context import Context
from oed.dynamics.effects.entries.history import CLOCK, by_duration, start_of
from oed.dynamics.effects.entries.plausibility import at_most, finite, first_reason
from oed.dynamics.effects.entry import CatalogueEntry, EffectPage, Shape, Target
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.effects.rigid_body import RigidBody
from oed.dynamics.identifiability import with_right_angles
from oed.dynamics.motion import random_motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import JointLimits, Robot

# A load's first moments matter most. Its mass comes last: where no motion tells it from a part of
# the inertia, a few grams far out would pass for kilograms.
LOAD_PREFERENCE = (1, 2, 3, 4, 5, 6, 7, 8, 9, 0)
SWING = 0.2  # [s] within which no arm goes to and fro
MOST_MOMENTS = 400
FOR_GOOD = 1e5  # [s] that a load is held
HELD = 0.03  # least share of a recording, or of the session
STRETCHES = 12  # of a recording, at the ends of which a load may be put down
STATES = 60  # random states that show which of ten columns differ


def _moments(context: Context, _target: Target, shapes: tuple[Shape, ...]) -> tuple[Shape, ...]:
    moment, clock = by_duration(context, shapes[:2], 0.03, 0.97)
    # The arm hardly shows a load where it rests or turns: every swing of it has a crest.
    fine = min(int((moment.upper - moment.lower) / SWING), MOST_MOMENTS)
    also = context.between if context.ordered else ()
    held = dataclasses.replace(shapes[2], lower=HELD * moment.upper, upper=moment.upper)
    return dataclasses.replace(moment, also=also, fine=fine), clock, held


def _put_down(context: Context) -> Iterator[tuple[float, ...]]:
    """A load that is held for a while: two of some times within a single recording."""
    if context.recordings > 1:
        return
    times = np.linspace(0.0, context.duration, STRETCHES + 1)
    clock = 0.0 if context.session is None else 1.0
    for k, moment in enumerate(times[1:-1], start=1):
        for release in times[k + 1 : -1]:
            yield float(moment), clock, float(release - moment)


def _payload(context: Context, _target: Target, values: tuple[float, ...]) -> PayloadChange:
    robot = context.model.robot
    last = robot.outward[-1]
    kept = _visible(context)
    moment, clock, held = values
    start = start_of(context, clock)
    held_for = held if held < FOR_GOOD else np.inf
    return PayloadChange(robot, last, moment, kept, start, context.reference, held_for)


@dataclass(frozen=True)
class VisibleLoad:
    """What of a load an arm's torque shows.

    Attributes:
        kept: Which of its ten standard parameters make a torque of their own.
        regrouping: (k, 10) matrix of what each of them stands for.
        expressions: (k,) the same in words, such as "Izz_2 + 0.0025 m_2".
    """

    kept: tuple[int, ...]
    regrouping: Float[ndarray, "kept 10"]
    expressions: tuple[str, ...]


def visible_load(robot: Robot, link: int) -> VisibleLoad:
    """What of a load at a link an arm's torque shows.

    Unlike a link's, a load's parameters cannot be regrouped into the links before it: it
    comes and goes.
    """
    free = with_right_angles(robot).with_limits(JointLimits.unlimited(robot.n))
    motion = random_motion(free, STATES, np.random.default_rng(0))
    whole = TorqueModel(free, (RigidBody(free),))
    columns = slice(10 * link, 10 * link + 10)
    base = find_base_parameters(
        whole.regressor(motion)[:, columns],
        whole.parameters[columns],
        preference=LOAD_PREFERENCE,
    )
    order = np.argsort(base.columns)
    return VisibleLoad(
        tuple(int(column) for column in base.columns[order]),
        base.regrouping[order],
        tuple(base.expressions[k] for k in order),
    )


@lru_cache(maxsize=8)
def _visible(context: Context) -> tuple[int, ...]:
    """Of a load at the last link."""
    robot = context.model.robot
    return visible_load(robot, robot.outward[-1]).kept


def _payload_plausible(
    context: Context,
    _target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    kept = _visible(context)
    reasons = [finite(estimates)]
    if 0 in kept:
        mass = float(estimates[kept.index(0)])
        moved = float(np.abs(context.reference.robot.parameters[::10]).sum())
        if moved > 0:
            reasons.append(at_most(mass, 5 * moved, "the load's mass", "kg", "5 times the arm's"))
    return first_reason(reasons)


PAYLOAD_CHANGE = CatalogueEntry(
    name="payload_change",
    scope="arm",
    shapes=(
        Shape("moment", "s", 0.0, 1e5, "linear", 19, 10.0),
        CLOCK,
        Shape("held", "s", 0.1, 1e4, "linear", 1, FOR_GOOD, never=True),
    ),
    build=_payload,
    plausible=_payload_plausible,
    narrow=_moments,
    beside_grid=_put_down,
    between_repetitions=True,
    equivalent=("a payload that never changes: part of the last link",),
    page=EffectPage(
        equation="H_last(q, dq, ddq) π_load from t_0 on, for good or for a while",
        source="Khalil, Gautier, Lemoine 2007, IEEE Int. Conf. Robotics and Automation, 3492-3497; "
        "Swevers, Verdonck, Naumer, Pieters, Biber 2002, Int. J. Robotics Research 21(8)",
        parameters="up to ten standard parameters of the load in the last body's frame; t_0 in s "
        "since the start of the recording or of the session",
        signature="repetitions before a moment differ from those after it, in inertia and gravity",
        confused_with=("thermal_drift", "gravity_direction"),
        exposed_by="the same motion with a known mass",
    ),
)
