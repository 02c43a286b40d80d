"""Effects that remember: what came before the present state decides the torque."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.context import Context
from oed.dynamics.effects.entries.plausibility import (
    at_most,
    first_reason,
    joint_of,
    positive,
)
from oed.dynamics.effects.entry import CatalogueEntry, EffectPage, Shape, Target
from oed.dynamics.effects.hysteresis import PreslidingHysteresis
from oed.dynamics.effects.thermal import ThermalDrift, WarmFriction

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
    scope="joint",
    shapes=(
        Shape("distance", "rad", 3e-4, 0.08, "log", 12, 5e-3, open_below=True),
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


# In place of a time constant: friction does not decay by itself, but follows a thermometer.
MEASURED = 1e9  # [s]

# Which clock counts: 0, every recording has its own; 1, one clock runs through the session.
CLOCK = Shape("clock", "1", 0.0, 1.0, "choice", 2, 0.0)


def by_duration(
    context: Context, shapes: tuple[Shape, ...], least: float, largest: float
) -> tuple[Shape, ...]:
    """A time, and which clock counts, with ranges that the recordings at hand can tell apart.

    Args:
        context: What is known.
        shapes: The time, and the clock.
        least: Share of a recording below which it is too short.
        largest: Share of it, or of the session, above which it is too long.
    """
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


def start_of(context: Context, clock: float) -> float | None:
    """Origin of time [s]; None for the first sample of each recording."""
    return context.session[0] if context.session is not None and clock >= 0.5 else None


def _time_constants(
    context: Context, _target: Target, shapes: tuple[Shape, ...]
) -> tuple[Shape, ...]:
    # Beyond a few durations the decay is a straight line, whatever its time constant.
    return by_duration(context, shapes, 0.05, 3.0)


def _by_thermometer(context: Context) -> Iterator[tuple[float, ...]]:
    """Friction that follows a temperature, where one was measured and changed."""
    if context.temperature_range is not None:
        yield MEASURED, 0.0


def _thermal(
    context: Context, target: Target, values: tuple[float, ...]
) -> ThermalDrift | WarmFriction:
    joint, (time_constant, clock) = joint_of(target), values
    width = context.sign_width(joint)
    if time_constant == MEASURED:
        return WarmFriction(joint, float(_temperatures(context)[joint].mean()), width)
    return ThermalDrift(joint, time_constant, start_of(context, clock), width)


def _temperatures(context: Context) -> Float[ndarray, "joints 2"]:
    if context.temperature_range is None:
        raise ValueError("no temperature was measured in all recordings: none can be followed")
    return context.temperature_range


def _thermal_plausible(
    context: Context,
    target: Target,
    values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    joint = joint_of(target)
    viscous, coulomb = (float(x) for x in estimates)
    top = float(context.top_speed[joint])
    excess = viscous * top + coulomb
    warm = context.friction_at_top_speed(joint)
    if values[0] == MEASURED:
        span = excess * float(np.ptp(_temperatures(context)[joint]))
        least = warm - abs(span) / 2
        words = "how much friction changes with temperature", "3 times the least friction"
        return at_most(abs(span), 3 * least, words[0], "N m", words[1]) if warm > 0 else None
    if warm <= 0:
        return positive(excess, "the excess friction of the cold joint", "N m")
    # A slow change ends with the log: what it would come to long after, nobody has seen.
    left = excess * float(np.exp(-_time_seen(context, values[1]) / values[0]))
    lost, last = excess - left, warm + left
    if excess > 0:
        return at_most(lost, 3 * last, "the excess", "N m", "3 times the last friction")
    # One that cools, or whose bearings tighten as they expand.
    return at_most(lost, last, "what friction lacks at first", "N m", "the last friction")


def _time_seen(context: Context, clock: float) -> float:
    """How long a change was looked at [s]: a recording, or the session."""
    if start_of(context, clock) is None or context.session is None:
        return context.duration
    return context.session[1] - context.session[0]


THERMAL_DRIFT = CatalogueEntry(
    name="thermal_drift",
    scope="joint",
    shapes=(Shape("time_constant", "s", 2.0, 2e4, "log", 8, 600.0, never=True), CLOCK),
    build=_thermal,
    plausible=_thermal_plausible,
    narrow=_time_constants,
    beside_grid=_by_thermometer,
    between_repetitions=True,
    page=EffectPage(
        equation="exp(-t/T) (a dq + b s), t since the start of the recording or of the session; "
        "where all recordings have the joint's temperature Θ also (Θ - Θ_r) (a dq + b s)",
        source="Bittencourt and Gunnarsson 2012, J. Dynamic Systems, Measurement, and Control "
        "134(5); Simoni, Beschi, Legnani, Visioli 2015, IEEE/RSJ IROS",
        parameters="a in N m s/rad and b in N m, 5 to 40 % of the warm values, negative "
        "where the joint cools or bearings tighten as they warm; T in s, at least 2; by temperature "
        "a and b are for each kelvin, and mostly negative",
        signature="repetitions of one motion differ, less and less",
        confused_with=("payload_change", "nonlinear_viscous"),
        exposed_by="the same motion cold and warm",
    ),
)
