"""Effects that grow with the joint's torque."""

from __future__ import annotations

import dataclasses
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.actuator import GainError, TorqueGain
from oed.dynamics.effects.context import Context
from oed.dynamics.effects.entries.plausibility import (
    at_most,
    first_reason,
    joint_of,
    peak_torque,
    positive,
)
from oed.dynamics.effects.entry import CatalogueEntry, EffectPage, Shape, Target
from oed.dynamics.effects.load import (
    MOST_LOSS,
    MOST_LOST,
    LoadFriction,
    TorqueSaturation,
    series_powers,
)
from oed.dynamics.torque_model import TorqueModel

# Power from which on a saturation may have two terms: it begins with the third, in between data may
# say less, and a square less a cube is much like a share of the torque.
LEAST_OF_SERIES = 2.5
# Formulas of a saturation, by the number of the shape that counts them.
FORMS: dict[int, Literal["power", "series", "limit"]] = {1: "power", 2: "series", 3: "limit"}
# The same of friction under load.
LOADS: dict[int, Literal["proportional", "second order", "by power"]] = {
    1: "proportional",
    2: "second order",
    3: "by power",
}
LOSS_WORDS = "the loss of a gear that hardly turns back"
LEAST_BACK = 0.1  # of a gear's loss, by which an estimate of none on the way back may be below zero
MOST_CUT = 1.2  # of what lies beyond a limit, beside a peak that is known by the model alone
SHARES = 21  # of the peak, at which a saturation of two terms is looked at


def _load_friction(context: Context, target: Target, values: tuple[float, ...]) -> LoadFriction:
    joint, (share, terms) = joint_of(target), values
    form = LOADS[round(terms)]
    return LoadFriction(
        joint,
        context.reference,
        share,
        context.sign_width(joint),
        peak_torque(context, joint) if form == "second order" else None,
        by_power=form == "by power",
    )


def _load_friction_plausible(
    _context: Context,
    _target: Target,
    values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    if LOADS[round(values[1])] == "by power":
        driving, driven = estimates.tolist()
        is_none = abs(driven) <= LEAST_BACK * driving
        return first_reason(
            [
                positive(driving, "mu where the joint drives its load", "1"),
                None if is_none else positive(driven, "mu where the load drives the joint", "1"),
                *(at_most(mu, MOST_LOSS, "mu", "1", LOSS_WORDS) for mu in (driving, driven)),
            ]
        )
    at_peak = float(estimates.sum())
    return first_reason(
        [
            positive(at_peak, "mu at the peak", "1"),
            at_most(at_peak, MOST_LOSS, "mu", "1", LOSS_WORDS),
            # Beside Coulomb friction a small load may take a little of it away.
            positive(at_peak + float(estimates[0]), "mu at half of the peak", "1"),
        ]
    )


LOAD_DEPENDENT_FRICTION = CatalogueEntry(
    name="load_dependent_friction",
    scope="joint",
    shapes=(
        Shape("share", "1", -1.0, 1.0, "linear", 3, 0.0, plain=True),
        Shape("terms", "1", 1.0, float(max(LOADS)), "formula", 1, 1.0),
    ),
    build=_load_friction,
    plausible=_load_friction_plausible,
    page=EffectPage(
        equation="μ |τ_l| s with the load τ_l = τ_rigid + ρ τ_rest; for negative ρ τ_weight + "
        "(1 + ρ) τ_inertial; to second order with μ' τ_l² / τ_peak s (terms 2); with another μ where "
        "the load drives the joint, τ_l s < 0 (terms 3)",
        source="Gogoussis and Donath 1988, IEEE Int. Conf. Robotics and Automation; Hamon, Gautier, "
        "Garrec 2010, IEEE/RSJ IROS, 6187-6193; Bittencourt and Gunnarsson 2012, J. Dynamic "
        "Systems, Measurement, and Control 134(5)",
        parameters="μ 0.02 to 0.12; ρ 0 (load at the gear's output) to 1 (at its input), or to -1 "
        "(the weight alone); μ' where friction grows faster than the load; two μ of a gear that loses "
        "more one way than the other",
        signature="friction grows with the load; turns its sign with the velocity",
        confused_with=("torque_saturation", "torque_gain", "position_dependent_friction"),
        exposed_by="a payload; both directions at high and at low load",
    ),
)


def _saturation(context: Context, target: Target, values: tuple[float, ...]) -> TorqueSaturation:
    joint, (exponent, terms) = joint_of(target), values
    peak = peak_torque(context, joint)
    return TorqueSaturation(joint, context.reference, peak, exponent, FORMS[round(terms)])


def _saturation_plausible(
    context: Context,
    target: Target,
    values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    peak = float(context.peak_torque[joint_of(target)])
    if FORMS[round(values[1])] == "limit":
        return first_reason(
            [
                positive(float(estimates[0]), "what a limit cuts off", "N m"),
                at_most(
                    values[0] * float(estimates[0]),
                    MOST_CUT * peak,
                    "the cut",
                    "N m",
                    "all beyond it",
                ),
            ]
        )
    if len(estimates) > 1 and values[0] < LEAST_OF_SERIES:
        return f"a series from the power {values[0]:.3g} on passes for a gain, not for saturation"
    powers = series_powers(values[0])[: len(estimates)]
    # Of two terms of opposite sign, one may undo at the peak what both do below it.
    lost = np.linspace(0, 1, SHARES)[:, None] ** powers @ estimates
    largest = float(np.abs(lost).max())
    return at_most(
        largest, MOST_LOST * peak, "the change at the peak", "N m", f"{MOST_LOST:g} of the peak"
    )


TORQUE_SATURATION = CatalogueEntry(
    name="torque_saturation",
    scope="joint",
    shapes=(
        Shape("exponent", "1", 2.0, 50.0, "log", 5, 3.0),
        Shape("terms", "1", 1.0, float(max(FORMS)), "formula", 1, 1.0),
    ),
    build=_saturation,
    plausible=_saturation_plausible,
    page=EffectPage(
        equation="-τ_s |τ/τ_peak|^m sgn τ; deep in saturation, with a further one of 2 m - 1; where a "
        "limit cuts (terms 3), -τ_s (1 + m (|τ/τ_peak| - 1)) sgn τ as far as that is no gain",
        source="Hendershot and Miller 2010, Design of Brushless Permanent-Magnet Machines, "
        "section 5",
        parameters="τ_s in N m, 3 to 15 % of the peak: lost there if positive, such as by a sensor "
        "or a drive that limits, and added if negative, by a current that rises as iron "
        "saturates; m 2 to 50: 3 for iron that begins to, "
        "large for a limit that cuts",
        signature="recorded torque bends away from the model's at high torque of both signs",
        confused_with=("load_dependent_friction", "torque_gain", "nonlinear_viscous"),
        exposed_by="peaks of both signs, at speed and near rest",
    ),
)


def _gain(context: Context, target: Target, values: tuple[float, ...]) -> GainError:
    return GainError(joint_of(target), context.reference, by_sign=values[0] > 1)


def _gain_plausible(
    _context: Context,
    _target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    size = float(np.abs(estimates).sum())
    return at_most(size, 0.6, "the gain error", "1", "a mistake in the file")


def _with_gain(
    context: Context,
    target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> TorqueModel:
    """Beside what is installed; a further step of the same gain adds to it."""
    error, by_sign = float(estimates[0]), float(estimates[1:].sum())
    joint, measured = joint_of(target), context.model.measurement
    gain = TorqueGain(joint, 1 + error, by_sign, context.reference)
    if measured and isinstance(last := measured[-1], TorqueGain) and last.joint == joint:
        sizes = {"gain": last.gain + error, "by_sign": last.by_sign + by_sign}
        gain, measured = dataclasses.replace(gain, **sizes), measured[:-1]
    return dataclasses.replace(context.model, measurement=(*measured, gain))


TORQUE_GAIN = CatalogueEntry(
    name="torque_gain",
    scope="joint",
    shapes=(Shape("terms", "1", 1.0, 2.0, "formula", 1, 1.0, also=(2.0,)),),
    build=_gain,
    plausible=_gain_plausible,
    install=_with_gain,
    equivalent=(
        "an arm of two joints: gain 1 + ε of one is gain 1/(1 + ε) of the other",
        "the same gain on all joints: a scale of all parameters",
    ),
    page=EffectPage(
        equation="ε (H θ)_j; where the data ask for it, with δ |(H θ)_j|",
        source="Gautier and Briot 2014, J. Dynamic Systems, Measurement, and Control 136(5)",
        parameters="ε 3 to 15 %, either sign; δ of an amplifier whose halves differ",
        signature="parameters that two rows share do not agree",
        confused_with=("rotor_inertia", "torque_saturation", "load_dependent_friction"),
        exposed_by="a known payload; motions of one joint at a time",
    ),
)
