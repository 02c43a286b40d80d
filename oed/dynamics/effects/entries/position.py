"""Torque that depends on the joint's position."""

from __future__ import annotations

import dataclasses
import math
from functools import partial

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.context import Context
from oed.dynamics.effects.entries.plausibility import (
    at_most,
    first_reason,
    joint_of,
    peak_torque,
    positive,
    share_of_coulomb,
)
from oed.dynamics.effects.entry import CatalogueEntry, EffectPage, Shape, Target
from oed.dynamics.effects.position import (
    LINEAR,
    PROGRESSIVE,
    JointSpring,
    PositionFriction,
    TorqueRipple,
)

# Harmonics closer than this over the range of motion share most of their wave: two trial
# values a radian of phase.
PHASE_STEP = 2.0  # [rad]
MOST_TRIALS = 600
# Multiples of the gear ratio worth looking at: once, twice and four times a motor turn.
MOTOR_HARMONICS = 4.2
LEAST_PERIODS = 2.0
ROUNDING = 1e-6
RIPPLE_SHARE = 0.1  # of the peak torque; drives are sold with 1 to 5 %
LEAST_RANGE = 0.05  # [rad]
# Of Coulomb friction as it is known without the wave: where the arm sees less than a whole one, its
# mean there is part of that.
MOST_UNEVEN = 1.5
MOST_SPRING = 2.0  # peak torques: what a balancer carries, the drive does not show
# Multiples of a wave's harmonic, by its formula: with its first overtone; with the second, since
# teeth and poles make no pure sines; with half of it, since an error of a current sensor's gain
# comes twice an electrical turn, and that of its zero once.
MULTIPLES = {1: (1.0,), 2: (1.0, 2.0), 3: (1.0, 2.0, 3.0), 4: (1.0, 2.0, 0.5)}
# Waves a turn of what turns with a joint out of true: a shaft or a seal once, a bent one twice, a
# bearing pressed in at three places.
WAVES = Shape("waves", "1", 1.0, 2.0, "formula", 1, 1.0)
RIPPLE_WAVES = dataclasses.replace(WAVES, upper=float(max(MULTIPLES)))
# Orders of a spring, by its formula, and stretches of the range that each have their own stiffness:
# coarse ones for a cable that goes slack, fine ones for one that is slack in the middle of the range.
ORDERS = {1.0: (LINEAR, 1), 2.0: (PROGRESSIVE, 1), 3.0: (LINEAR, 5), 4.0: (LINEAR, 15)}
PLACES = 51  # of the range, at which a spring must pull back harder the further it is stretched
# Of its largest stiffness, by which a spring in stretches may fall short of that: where a cable goes
# slack within one of five, the next of the best fit has -0.12 to -0.14 of it.
SLACK = 0.2


def _with_overtones(values: tuple[float, ...]) -> tuple[float, ...]:
    """Harmonics of a wave, by its shapes."""
    harmonic, waves = values
    return tuple(k * harmonic for k in MULTIPLES[round(waves)])


def _spaced_by_range(context: Context, joint: int, shape: Shape) -> Shape:
    least, largest = context.position_range[joint]
    step = PHASE_STEP / max(float(largest - least), LEAST_RANGE)
    points = min(max(1 + math.ceil((shape.upper - shape.lower) / step), 3), MOST_TRIALS)
    return dataclasses.replace(shape, points=points)


def _ripple_harmonics(
    context: Context, target: Target, shapes: tuple[Shape, ...]
) -> tuple[Shape, ...]:
    joint, shape = joint_of(target), shapes[0]
    # Teeth and poles are counted on the pinion of a slide.
    radius = context.model.robot.joints[joint].speed(1.0)
    shape = dataclasses.replace(shape, upper=shape.upper / radius)
    # Fewer periods within the motion than these are a slope and a bend: any function of position.
    swing = max(float(np.ptp(context.position_range[joint])), LEAST_RANGE)
    least = max(shape.lower, LEAST_PERIODS * 2 * np.pi / swing)
    default, upper = max(shape.default, least), max(shape.upper, 2 * least)
    shape = dataclasses.replace(shape, lower=least, upper=upper, default=default)
    if (ratio := context.drives.gear_ratio) is not None:
        upper = max(MOTOR_HARMONICS * abs(ratio[joint]), shape.upper)
        shape = dataclasses.replace(shape, upper=upper)
    return (_spaced_by_range(context, joint, shape), *shapes[1:])


def _ripple(_context: Context, target: Target, values: tuple[float, ...]) -> TorqueRipple:
    return TorqueRipple(joint_of(target), _with_overtones(values))


def _wave_plausible(
    context: Context,
    target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
    *,
    most: float = 1.0,
) -> str | None:
    amplitude = float(np.linalg.norm(estimates))
    return share_of_coulomb(context, joint_of(target), amplitude, most, "the amplitude")


def _ripple_plausible(
    context: Context,
    target: Target,
    values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    joint, (harmonic, _) = joint_of(target), TORQUE_RIPPLE.shapes_for(context, target)
    # Half a wave may be longer than a ripple is, but then it is not most of it.
    waves = np.linalg.norm(estimates.reshape(-1, 2), axis=1)
    is_long = np.array(_with_overtones(values)) < harmonic.lower * (1 - ROUNDING)
    amplitude, longer = float(np.linalg.norm(waves)), float(np.linalg.norm(waves[is_long]))
    if longer > float(np.linalg.norm(waves[~is_long])):
        return f"most of it has fewer than {LEAST_PERIODS:g} periods within the motion"
    # No friction: it grows with the drive, whose gears may have little of that.
    most = max(context.coulomb(joint), RIPPLE_SHARE * peak_torque(context, joint))
    bound = f"Coulomb friction and {RIPPLE_SHARE:.0%} of the peak torque"
    return at_most(amplitude, most, "the amplitude", "N m", bound)


TORQUE_RIPPLE = CatalogueEntry(
    name="torque_ripple",
    scope="joint",
    shapes=(
        Shape("harmonic", "1/turn", 2.0, 330.0, "linear", 500, 6.0, is_bounded=True),
        RIPPLE_WAVES,
    ),
    build=_ripple,
    plausible=_ripple_plausible,
    narrow=_ripple_harmonics,
    page=EffectPage(
        equation="a cos(n q) + b sin(n q), with overtones at 2 n and 3 n, or at 2 n and n / 2, and the "
        "mean of an uneven ripple, up to a quarter of its amplitude, where the data ask for them",
        source="Holtz and Springob 1996, IEEE Trans. Industrial Electronics 43(2), 309-319; Chung "
        "and Sul 1998, IEEE Trans. Industry Applications 34(2), 340-345 (n / 2); "
        "Taghirad and Bélanger 1998, J. Dynamic Systems, Measurement, and Control 120(4)",
        parameters="a, b in N m, amplitude 3 to 25 % of Coulomb friction; n periods a joint turn: "
        "gear ratio times motor poles, twice the ratio of a harmonic drive, gear teeth",
        signature="a line in the spectrum over position, whatever the direction",
        confused_with=("position_dependent_friction", "joint_elasticity", "encoder_eccentricity"),
        exposed_by="slow constant speed over a wide range, both ways",
    ),
)


def _friction_harmonics(
    context: Context, target: Target, shapes: tuple[Shape, ...]
) -> tuple[Shape, ...]:
    joint, shape = joint_of(target), shapes[0]
    radius = context.model.robot.joints[joint].speed(1.0)  # of a slide's pinion, or a screw's lead
    bounds = {x: getattr(shape, x) / radius for x in ("lower", "upper", "default")}
    shape = dataclasses.replace(shape, **bounds)
    return (_spaced_by_range(context, joint, shape), *shapes[1:])


def _position_friction(
    context: Context, target: Target, values: tuple[float, ...]
) -> PositionFriction:
    joint = joint_of(target)
    return PositionFriction(joint, _with_overtones(values), context.sign_width(joint))


POSITION_DEPENDENT_FRICTION = CatalogueEntry(
    name="position_dependent_friction",
    scope="joint",
    shapes=(
        Shape("harmonic", "1/turn", 0.5, 16.0, "linear", 24, 1.0),
        WAVES,
    ),
    build=_position_friction,
    plausible=partial(_wave_plausible, most=MOST_UNEVEN),
    narrow=_friction_harmonics,
    page=EffectPage(
        equation="(a cos(k q) + b sin(k q)) s, with its overtone at 2 k where the data ask for it",
        source="Armstrong 1988, IEEE Int. Conf. Robotics and Automation, 1440-1447; Popović and "
        "Goldenberg 1998, IEEE Trans. Robotics and Automation 14(1), 114-122",
        parameters="a, b in N m, amplitude 5 to 40 % of Coulomb friction; k periods a joint turn, "
        "mostly 1, 2 or 3",
        signature="Coulomb friction that varies with position; turns its sign with the velocity",
        confused_with=("load_dependent_friction", "torque_ripple"),
        exposed_by="both directions through every position",
    ),
)


def _spring(context: Context, target: Target, values: tuple[float, ...]) -> JointSpring:
    joint = joint_of(target)
    least, largest = (float(x) for x in context.position_range[joint])
    order, stretches = ORDERS[values[0]]
    bends = np.linspace(least, largest, stretches + 1)[1:-1].round(6).tolist()
    centre, constant = round((least + largest) / 2, 6), not context.has_offset(joint)
    return JointSpring(joint, centre, constant=constant, order=order, bends=tuple(bends))


def _spring_plausible(
    context: Context,
    target: Target,
    values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    joint, (order, stretches) = joint_of(target), ORDERS[values[0]]
    least, largest = (float(x) for x in context.position_range[joint])
    reach = np.linspace(least - largest, largest - least, PLACES) / 2
    powers = np.polynomial.Polynomial([0.0, *estimates[:order]])
    changes = estimates[order : order + stretches - 1]
    bends = np.linspace(reach[0], reach[-1], stretches + 1)[1:-1]
    stiffness = powers.deriv()(reach) + (reach[:, None] > bends) @ changes
    pulled = powers(reach) + np.maximum(reach[:, None] - bends, 0.0) @ changes
    short = SLACK * float(stiffness.max()) if stretches > 1 else 0.0
    bound = MOST_SPRING * peak_torque(context, joint)
    return first_reason(
        [
            positive(float(stiffness.min()) + short, "the least stiffness", "N m/rad"),
            at_most(
                float(np.ptp(pulled)) / 2,
                bound,
                "the spring's torque",
                "N m",
                "twice the peak torque",
            ),
        ]
    )


JOINT_SPRING = CatalogueEntry(
    name="joint_spring",
    scope="joint",
    shapes=(Shape("terms", "1", 1.0, float(max(ORDERS)), "formula", 1, 1.0),),
    holds=("torque_offset",),
    build=_spring,
    plausible=_spring_plausible,
    equivalent=("its constant part: torque_offset",),
    page=EffectPage(
        equation="k (q - q_0) = k (q - q_c) + τ_c, q_c the middle of the range; where it tightens, "
        "with k_2 (q - q_c)² + k_3 (q - q_c)³; where it goes slack, with another k in each fifth of the "
        "range, or each fifteenth",
        source="Wang, Gondokaryono, Munawar, Fischer 2019, IEEE Robotics and Automation Letters "
        "4(4), 3657-3664",
        parameters="k > 0 in N m/rad, 0.1 to 1.2 of Coulomb friction a rad, the slope positive all "
        "over the range, or zero where it is slack; τ_c in N m",
        signature="a torque even in velocity that rises along the range",
        confused_with=("gravity_direction", "torque_offset", "torque_ripple"),
        exposed_by="the whole range of the joint: a line where gravity is a sine",
    ),
)
