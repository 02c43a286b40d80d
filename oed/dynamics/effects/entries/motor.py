"""What a drive adds to its own joint and to others."""

from __future__ import annotations

import dataclasses

from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.context import Context
from oed.dynamics.effects.entries.plausibility import (
    at_most,
    finite,
    first_reason,
    joint_of,
    pair_of,
    positive,
)
from oed.dynamics.effects.entry import CatalogueEntry, EffectPage, Shape, Target
from oed.dynamics.effects.motor import CrossCoupling, MixedTorque, MotorCoupling, RotorInertia

ONE_WAY = 0.05  # a ratio below this: the joint hardly turns the motor, which is recorded in its row
FALLING = 0.5  # share of its friction at rest that a motor may lose at top speed
SMALL = 0.1  # of what else a motor does, up to which a part of it may be noise
# Of one that turns with both alike, the outer joint is named: each would do. Ratios meet in between.
ALIKE = 0.9
# What a coupled motor shows in: its torque in one row, its inertia in both, or, in a log of motors'
# torques, all that its joint needs in the row of the other.
BOTH_ROWS, WHOLE_TORQUE = 2.0, 3.0
MOST_SHARE = 1.5  # of a joint's torque that the motor of another one carries; ratios are up to 1
# Of a motor that two joints turn; a wrist's gears have 0.2 to 1. A smaller share of another torque
# may be crosstalk of current sensors as well.
LEAST_RATIO = 0.1


def _rotor(_context: Context, target: Target, _values: tuple[float, ...]) -> RotorInertia:
    return RotorInertia(joint_of(target))


def _rotor_plausible(
    _context: Context,
    _target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    return positive(float(estimates[0]), "rotor inertia", "kg m^2")


ROTOR_INERTIA = CatalogueEntry(
    name="rotor_inertia",
    scope="joint",
    shapes=(),
    build=_rotor,
    plausible=_rotor_plausible,
    equivalent=("on the first joint: part of the first link's inertia about its axis",),
    page=EffectPage(
        equation="I_a ddq",
        source="Khalil and Dombre 2002, Modeling, Identification and Control of Robots, section "
        "9.4; Madsen et al. 2020, Control Engineering Practice 101",
        parameters="I_a > 0 in kg m², gear ratio squared times the motor's, 3 to 15 % of M_jj",
        signature="inertia that the joint's own row shows and no other row",
        confused_with=("torque_gain", "joint_elasticity"),
        exposed_by="accelerations of one joint while the others stand or move independently",
    ),
)


def _coupling(
    context: Context, target: Target, values: tuple[float, ...]
) -> CrossCoupling | MixedTorque | MotorCoupling:
    joint, other = pair_of(target)
    if _is_mixed(values):
        return MixedTorque(joint, other, context.reference)
    width = max(context.sign_width(joint), context.sign_width(other))
    if abs(values[0]) < ONE_WAY:
        return CrossCoupling(joint, other, width, mutual=round(values[1]) == BOTH_ROWS)
    return MotorCoupling((joint, other), (values[0], 1.0), width)


def _is_mixed(values: tuple[float, ...]) -> bool:
    return abs(values[0]) < ONE_WAY and values[1] == WHOLE_TORQUE


def _ratios(context: Context, target: Target, shapes: tuple[Shape, ...]) -> tuple[Shape, ...]:
    joint, other = pair_of(target)
    ratio, rows = shapes
    if context.drives.of_motors:
        rows = dataclasses.replace(rows, upper=WHOLE_TORQUE, also=(*rows.also, WHOLE_TORQUE))
    if joint < other:
        return dataclasses.replace(ratio, lower=-ALIKE, upper=ALIKE), rows
    return dataclasses.replace(ratio, lower=-1 / ALIKE, upper=1 / ALIKE), rows


def _coupling_plausible(
    context: Context,
    target: Target,
    values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    if _is_mixed(values):
        share = abs(float(estimates[0]))
        if share < LEAST_RATIO:
            return f"a share of {share:.2g} of another joint's torque is none of gears"
        return at_most(share, MOST_SHARE, "the share", "1", "that of any gears")
    joint, other = pair_of(target)
    one_way = abs(values[0]) < ONE_WAY
    if not one_way and abs(values[0]) < LEAST_RATIO:
        return f"at a ratio of {values[0]:.2g} the motor does not turn with the joint"
    speed, acceleration = (
        float(top[other] + (0.0 if one_way else abs(values[0])) * top[joint])
        for top in (context.top_speed, context.top_acceleration)
    )
    if reason := finite(estimates) or _mere_drag(estimates, speed, acceleration):
        return reason
    if one_way:
        return _both_ways(context, other, estimates)
    inertia, viscous, coulomb = (float(x) for x in estimates)
    friction = viscous * speed + coulomb
    # Beside friction that does much more, an inertia may be noise.
    small = abs(inertia) * acceleration < SMALL * friction
    return first_reason(
        [
            None if small else positive(inertia, "the motor's inertia", "kg m^2"),
            positive(friction, "the motor's friction at top speed", "N m"),
        ]
    )


def _mere_drag(
    estimates: Float[ndarray, " columns"], speed: float, acceleration: float
) -> str | None:
    """Why a drag on another joint's speed is no motor: that has inertia, and friction at rest."""
    inertia, viscous, coulomb = (abs(float(x)) for x in estimates)
    if max(inertia * acceleration, coulomb) >= SMALL * viscous * speed:
        return None
    return f"nothing but a drag of {viscous * speed:.3g} N m at top speed: no motor has that alone"


def _both_ways(context: Context, other: int, estimates: Float[ndarray, " columns"]) -> str | None:
    """Why friction cannot be a motor's: what it gives at rest and what speed adds are two ways.

    Beside an inertia that does much more, both may be noise.
    """
    inertia, viscous, coulomb = (float(x) for x in estimates)
    added = viscous * float(context.top_speed[other])
    driving = abs(inertia) * float(context.top_acceleration[other])
    if added * coulomb >= 0 or abs(coulomb) < SMALL * abs(added):
        return None
    if abs(added) < FALLING * abs(coulomb):
        return None
    if max(abs(added), abs(coulomb)) < driving:
        return None
    return (
        f"the motor's friction turns from {coulomb:.3g} N m at rest to "
        f"{coulomb + added:.3g} N m at top speed: it has one sign"
    )


MOTOR_COUPLING = CatalogueEntry(
    name="motor_coupling",
    scope="pair",
    shapes=(
        Shape("ratio", "1", -1.0, 1.0, "linear", 3, 0.0),
        Shape("rows", "1", 1.0, BOTH_ROWS, "formula", 1, BOTH_ROWS, also=(1.0,)),
    ),
    build=_coupling,
    plausible=_coupling_plausible,
    narrow=_ratios,
    equivalent=(
        "the pair in the other order, for ratios of 1 and -1: the outer joint is named",
        "the same for an inertia in both rows and no friction: the inner joint is named",
    ),
    holds=("rotor_inertia",),
    page=EffectPage(
        equation="on joint j, r times what is on joint i: I_a u' + F_v u + F_c sgn u, u = dq_i + r "
        "dq_j; at r = 0: I_x ddq_i + F_xv dq_i + F_xc sgn dq_i on joint j, I_x ddq_j on joint i; of "
        "motors' torques on joint j alone, or a share of joint i's whole torque there",
        source="Janot, Vandanjon, Gautier 2014, IEEE Trans. Control Systems Technology 22(1), "
        "132-145 (wrist of the Stäubli TX40)",
        parameters="inertia in kg m², viscous in N m s/rad and Coulomb friction in N m of the "
        "coupled motor; ratio r; rows that show the inertia at r = 0 (1 or 2), or 3 for the share",
        signature="the residual of one joint follows another joint's velocity and acceleration",
        confused_with=("torque_gain", "rotor_inertia"),
        exposed_by="moving one joint at a time",
    ),
)
