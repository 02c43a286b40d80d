"""Friction that is a function of one joint's velocity, and the offset beside it."""

from __future__ import annotations

import dataclasses

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
from oed.dynamics.effects.nonlinear_viscous import AsymmetricViscous, NonlinearViscous
from oed.dynamics.effects.offset import TorqueOffset
from oed.dynamics.effects.stribeck import Stribeck

MOST_RISE = 2.5  # of Coulomb friction, towards standstill: boundary lubrication has no more


def _stribeck(context: Context, target: Target, values: tuple[float, ...]) -> Stribeck:
    joint = joint_of(target)
    speed, exponent, tail = values
    return Stribeck(joint, speed, exponent, tail, context.sign_width(joint))


def _below_top_speed(
    context: Context, target: Target, shapes: tuple[Shape, ...]
) -> tuple[Shape, ...]:
    speed = shapes[0]
    # Beyond half of the top speed the fall is viscous friction by another name.
    top = max(min(speed.upper, 0.5 * float(context.top_speed[joint_of(target)])), speed.lower)
    narrowed = dataclasses.replace(speed, upper=top, default=min(speed.default, top))
    return (narrowed, *shapes[1:])


def _stribeck_plausible(
    context: Context,
    target: Target,
    values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    joint, rise = joint_of(target), float(estimates[0])
    return first_reason(
        [
            positive(rise, "the rise towards standstill", "N m"),
            share_of_coulomb(context, joint, rise, MOST_RISE, "the rise towards standstill"),
            at_most(
                values[0],
                float(context.top_speed[joint]),
                "the Stribeck speed",
                "rad/s",
                "the largest speed in the data",
            ),
        ]
    )


STRIBECK = CatalogueEntry(
    name="stribeck",
    scope="joint",
    shapes=(
        Shape("speed", "rad/s", 0.003, 1.0, "log", 14, 0.05),
        Shape("exponent", "1", 0.5, 4.0, "log", 3, 2.0),
        Shape("tail", "1", 0.0, 1.0, "linear", 2, 0.0, plain=True),
    ),
    build=_stribeck,
    plausible=_stribeck_plausible,
    narrow=_below_top_speed,
    page=EffectPage(
        equation="F_S d(|dq|/v_S) s, d(x) = (1 + c x^δ)^(-1/c), exp(-x^δ) at c = 0",
        source="Armstrong-Hélouvry, Dupont, Canudas de Wit 1994, Automatica 30(7), 1083-1138; "
        "Bo and Pavelescu 1982, Wear 82(3); Hess and Soom 1990, J. Tribology 112(1)",
        parameters="F_S > 0 in N m, usually 0.2 to 0.7 of Coulomb friction; v_S 0.01 to 0.25 rad/s; "
        "δ 0.5 to 4; tail c 0 (exponential) to 1 (algebraic)",
        signature="friction rises as the joint slows down; odd in velocity, gone at speed",
        confused_with=("presliding_hysteresis", "nonlinear_viscous", "filter_lag"),
        exposed_by="many slow passages through zero speed, and slow constant speeds both ways",
    ),
)


def _nonlinear_viscous(
    context: Context, target: Target, values: tuple[float, ...]
) -> NonlinearViscous:
    joint = joint_of(target)
    exponent, thinning = values
    return NonlinearViscous(joint, exponent, thinning, context.sign_width(joint))


def _nonlinear_viscous_plausible(
    context: Context,
    target: Target,
    values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    joint = joint_of(target)
    if estimates[0] < 0 and values[0] < 1:
        return "friction would fall as the joint sets off, which is Stribeck's effect"
    top = float(context.top_speed[joint])
    # Beyond alpha / (1 - alpha) of its own scale of speed the law falls.
    if values[0] < 1 and values[1] * top * (1 - values[0]) > values[0]:
        return "friction would rise at low speed alone, as a sign does that turns slowly"
    at_top = float(estimates[0]) * top ** values[0] / (1.0 + values[1] * top)
    # With a shape near the straight line the two trade places; only their sum is physical.
    whole = at_top + context.viscous(joint) * top
    return first_reason(
        [
            at_most(
                at_top,
                3.0 * peak_torque(context, joint),
                "the friction at top speed",
                "N m",
                "3 times the peak torque",
            ),
            positive(whole + context.coulomb(joint), "friction at top speed altogether", "N m"),
        ]
    )


NONLINEAR_VISCOUS = CatalogueEntry(
    name="nonlinear_viscous",
    scope="joint",
    shapes=(
        Shape("exponent", "1", 0.25, 3.5, "log", 10, 0.6),
        Shape("thinning", "s/rad", 0.0, 3.0, "linear", 3, 0.0, plain=True),
    ),
    build=_nonlinear_viscous,
    plausible=_nonlinear_viscous_plausible,
    page=EffectPage(
        equation="F_n |dq|^α / (1 + |dq|/v_0) s",
        source="Waiboer, Aarts, Jonker 2005, ECCOMAS Multibody Dynamics; Tuttle and Seering 1996, "
        "IEEE Trans. Robotics and Automation 12(3), 368-374; Madsen et al. 2020, Control "
        "Engineering Practice 101",
        parameters="F_n in N m (s/rad)^α, 5 to 50 % of viscous friction, positive where α < 1; "
        "α 0.3 to 0.8 or 1.5 to 3; 1/v_0 in s/rad",
        signature="a bend in friction against speed, odd in velocity, over the whole range",
        confused_with=("stribeck", "torque_saturation"),
        exposed_by="constant speeds over a decade",
    ),
)


def _asymmetric(_context: Context, target: Target, _values: tuple[float, ...]) -> AsymmetricViscous:
    return AsymmetricViscous(joint_of(target))


def _asymmetric_plausible(
    context: Context,
    target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    joint = joint_of(target)
    viscous, top = context.viscous(joint), float(context.top_speed[joint])
    if viscous <= 0 or top <= 0:
        return None
    # No joint drives itself; without it, some of it passes for friction, or friction for it.
    return at_most(
        float(estimates[0]),
        1.5 * max(viscous, context.friction_at_top_speed(joint) / top),
        "the difference of directions",
        "N m s/rad",
        "1.5 times friction at top speed",
    )


ASYMMETRIC_VISCOUS = CatalogueEntry(
    name="asymmetric_viscous",
    scope="joint",
    shapes=(),
    build=_asymmetric,
    plausible=_asymmetric_plausible,
    equivalent=("viscous friction of one direction only: the same column modulo viscous friction",),
    page=EffectPage(
        equation="F_a |dq|",
        source="Canudas de Wit, Åström, Braun 1987, IEEE J. Robotics and Automation 3(6), 681-685",
        parameters="F_a in N m s/rad, either sign, 5 to 35 % of viscous friction",
        signature="even in velocity and growing with it: the two directions differ",
        confused_with=("torque_offset", "thermal_drift"),
        exposed_by="several speeds in both directions through the same positions",
    ),
)


def _offset(_context: Context, target: Target, _values: tuple[float, ...]) -> TorqueOffset:
    return TorqueOffset(joint_of(target))


def _offset_plausible(
    context: Context,
    target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    joint = joint_of(target)
    return at_most(
        float(estimates[0]),
        peak_torque(context, joint),
        "the offset",
        "N m",
        "the peak torque",
    )


TORQUE_OFFSET = CatalogueEntry(
    name="torque_offset",
    scope="joint",
    shapes=(),
    build=_offset,
    plausible=_offset_plausible,
    equivalent=(
        "asymmetric Coulomb friction: half of the difference of the two directions",
        "constant torque of a cable or of a balancing spring",
        "a tilt of an arm whose joints all slide",
    ),
    page=EffectPage(
        equation="τ_0",
        source="Swevers, Verdonck, De Schutter 2007, IEEE Control Systems Magazine 27(5), 58-71",
        parameters="τ_0 in N m, either sign, 0.1 to 0.5 of Coulomb friction",
        signature="a constant on one joint",
        confused_with=("asymmetric_viscous", "joint_spring", "gravity_direction"),
        exposed_by="reading the torque with the drive off; nothing tells it from asymmetric "
        "Coulomb friction",
    ),
)
