"""Effects that remember: what came before the present state decides the torque."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.base_parameters import find_base_parameters
from oed.dynamics.effects.context import Context
from oed.dynamics.effects.entries.plausibility import (
    at_most,
    finite,
    first_reason,
    joint_of,
    positive,
)
from oed.dynamics.effects.entry import CatalogueEntry, EffectPage, Shape, Target
from oed.dynamics.effects.hysteresis import PreslidingHysteresis
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.effects.rigid_body import RigidBody
from oed.dynamics.effects.thermal import ThermalDrift
from oed.dynamics.identifiability import with_right_angles
from oed.dynamics.motion import random_motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import JointLimits, Robot

# A load's first moments matter most. Its mass comes last: where no motion tells it from a part of
# the inertia, a few grams far out would pass for kilograms.
LOAD_PREFERENCE = (1, 2, 3, 4, 5, 6, 7, 8, 9, 0)
SWING = 0.2  # [s] within which no arm goes to and fro
MOST_MOMENTS = 400
STATES = 60  # random states that show which of ten columns differ
# Of Coulomb friction as it is known without the build-up: where that takes much of the motion, the
# sign of the velocity explains but a fraction of what slides. The rest passes for viscous friction,
# so that all of the friction at full speed is a bound, too.
MOST_BUILT_UP = 6.0


def _hysteresis(
    context: Context, target: Target, values: tuple[float, ...]
) -> PreslidingHysteresis:
    joint = joint_of(target)
    distance, roundness = values
    return PreslidingHysteresis(joint, distance, roundness, context.sign_width(joint))


def _hysteresis_plausible(
    context: Context,
    target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    joint, built_up = joint_of(target), float(estimates[0])
    coulomb = context.coulomb(joint)
    whole = context.friction_at_top_speed(joint)
    name, bound = "the friction built up", max(MOST_BUILT_UP * coulomb, whole)
    return first_reason(
        [
            positive(built_up, "the friction that builds up", "N m"),
            at_most(built_up, bound, name, "N m", "all friction at full speed")
            if coulomb > 0
            else None,
        ]
    )


PRESLIDING_HYSTERESIS = CatalogueEntry(
    name="presliding_hysteresis",
    families=("odd in speed", "reversal"),
    scope="joint",
    shapes=(
        Shape("distance", "rad", 3e-4, 0.08, "log", 12, 5e-3),
        Shape("roundness", "1", 0.0, 1.0, "linear", 3, 0.7),
    ),
    build=_hysteresis,
    plausible=_hysteresis_plausible,
    page=EffectPage(
        equation="F_h (z(q) - s), z the mean of Maxwell elements with break-away distances of mean "
        "δ and spread ρ δ",
        source="Dahl 1968, Aerospace Corp. TOR-0158(3107-18)-1; Canudas de Wit, Olsson, Åström, "
        "Lischinsky 1995, IEEE Trans. Automatic Control 40(3); Al-Bender, Lampaert, Swevers 2005, "
        "IEEE Trans. Automatic Control 50(11), 1883-1887",
        parameters="F_h in N m, near Coulomb friction if all of it builds up; δ 0.5 to 40 mrad; "
        "ρ 0 (one element), 0.71 (Dahl, LuGre) to 1",
        signature="after each reversal the torque lags behind the sign, over a fixed distance",
        confused_with=("time_delay", "filter_lag", "stribeck", "backlash"),
        exposed_by="reversals of unequal size and speed, some smaller than δ",
    ),
)


# Which clock counts: 0, every recording has its own; 1, one clock runs through the session.
CLOCK = Shape("clock", "1", 0.0, 1.0, "choice", 2, 0.0)


def _by_duration(
    context: Context, shapes: tuple[Shape, ...], least: float, largest: float
) -> tuple[Shape, ...]:
    shape, clock = shapes
    longest = context.duration
    if context.session is None:
        clock = dataclasses.replace(clock, upper=0.0, points=1)
    elif context.recordings == 1:
        # Which one a single recording cannot tell: the next may go on with it, or start anew.
        clock = dataclasses.replace(clock, default=1.0, points=1)
    else:
        longest = context.session[1] - context.session[0]
    lower = max(least * context.duration, shape.lower)
    upper = max(largest * longest, 2 * lower)
    middle = float(np.sqrt(lower * upper)) if shape.scale == "log" else (lower + upper) / 2
    points = shape.points
    # Repetitions show a change by what they differ by, so that only a near moment explains it.
    if shape.scale == "linear" and context.ordered:
        points = round(points * longest / context.duration)
    shape = dataclasses.replace(shape, lower=lower, upper=upper, default=middle, points=points)
    return shape, clock


def _start(context: Context, clock: float) -> float | None:
    """Origin of time [s]; None for the first sample of each recording."""
    return context.session[0] if context.session is not None and clock >= 0.5 else None


def _time_constants(
    context: Context, _target: Target, shapes: tuple[Shape, ...]
) -> tuple[Shape, ...]:
    # Beyond a few durations the decay is a straight line, whatever its time constant.
    return _by_duration(context, shapes, 0.05, 3.0)


def _thermal(context: Context, target: Target, values: tuple[float, ...]) -> ThermalDrift:
    joint = joint_of(target)
    start = _start(context, values[1])
    return ThermalDrift(joint, values[0], start, width=context.sign_width(joint))


def _thermal_plausible(
    context: Context,
    target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    joint = joint_of(target)
    viscous, coulomb = (float(x) for x in estimates)
    top = float(context.top_speed[joint])
    excess = viscous * top + coulomb
    warm = context.friction_at_top_speed(joint)
    if warm <= 0:
        return positive(excess, "the excess friction of the cold joint", "N m")
    if excess > 0:
        return at_most(excess, 3 * warm, "the excess", "N m", "3 times the last friction")
    # One that cools, or whose bearings tighten as they expand.
    return at_most(excess, warm, "what friction lacks at first", "N m", "the last friction")


THERMAL_DRIFT = CatalogueEntry(
    name="thermal_drift",
    families=("time",),
    scope="joint",
    shapes=(Shape("time_constant", "s", 0.1, 2e4, "log", 8, 600.0), CLOCK),
    build=_thermal,
    plausible=_thermal_plausible,
    narrow=_time_constants,
    between_repetitions=True,
    page=EffectPage(
        equation="exp(-t/T) (a dq + b s), t since the start of the recording or of the session",
        source="Bittencourt and Gunnarsson 2012, J. Dynamic Systems, Measurement, and Control "
        "134(5); Simoni, Beschi, Legnani, Visioli 2015, IEEE/RSJ IROS",
        parameters="a in N m s/rad and b in N m, 5 to 40 % of the warm values, negative "
        "where the joint cools or bearings tighten as they warm; T in s",
        signature="repetitions of one motion differ, less and less",
        confused_with=("payload_change", "nonlinear_viscous"),
        exposed_by="the same motion cold and warm",
    ),
)


def _moments(context: Context, _target: Target, shapes: tuple[Shape, ...]) -> tuple[Shape, ...]:
    moment, clock = _by_duration(context, shapes, 0.03, 0.97)
    # The arm hardly shows a load where it rests or turns: every swing of it has a crest.
    fine = min(int((moment.upper - moment.lower) / SWING), MOST_MOMENTS)
    also = context.between if context.ordered else ()
    return dataclasses.replace(moment, also=also, fine=fine), clock


def _payload(context: Context, _target: Target, values: tuple[float, ...]) -> PayloadChange:
    robot = context.model.robot
    last = robot.outward[-1]
    kept = _visible(context)
    start = _start(context, values[1])
    return PayloadChange(robot, last, values[0], kept, start, context.reference, context.pickups)


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
    families=("time",),
    scope="arm",
    shapes=(Shape("moment", "s", 0.0, 1e5, "linear", 19, 10.0), CLOCK),
    build=_payload,
    plausible=_payload_plausible,
    narrow=_moments,
    between_repetitions=True,
    equivalent=("a payload that never changes: part of the last link",),
    page=EffectPage(
        equation="H_last(q, dq, ddq) π_load from t_0 on",
        source="Khalil, Gautier, Lemoine 2007, IEEE Int. Conf. Robotics and Automation, 3492-3497; "
        "Swevers, Verdonck, Naumer, Pieters, Biber 2002, Int. J. Robotics Research 21(8)",
        parameters="up to ten standard parameters of the load in the last body's frame; t_0 in s "
        "since the start of the recording or of the session, or one for each recording",
        signature="repetitions before a moment differ from those after it, in inertia and gravity",
        confused_with=("thermal_drift", "gravity_direction"),
        exposed_by="the same motion with a known mass",
    ),
)
