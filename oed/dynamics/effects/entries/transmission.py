"""What a gear between motor and links does: it gives way, and it may have play."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.context import Context
from oed.dynamics.effects.entries.plausibility import by_construction, joint_of, peak_torque
from oed.dynamics.effects.entry import Build, CatalogueEntry, EffectPage, Install, Shape, Target
from oed.dynamics.effects.rigid_body import RigidBody
from oed.dynamics.effects.transmission import (
    Backlash,
    JointElasticity,
    Rubbing,
    Transmission,
    TransmissionChange,
)
from oed.dynamics.torque_model import TorqueModel

LEAST_WIDTH = 1e-6  # [rad/s] of the sign of Coulomb friction behind a gear
LEAST_PLAY = 0.03  # of the gear's bend between the largest torques of both signs


def _gear(
    kind: Callable[..., Transmission], context: Context, target: Target, *values: float
) -> Transmission:
    """A gear from its frequency, damping, share of the rotor, gap and share of friction behind it."""
    first = context.model.effects[0]
    if isinstance(first, RigidBody):
        posture = tuple(float(x) for x in context.position_range.mean(axis=1))
        gear = kind(joint_of(target), *values, posture, context.unyielding)
        return _rubbing_behind(gear, context)
    raise ValueError(f"{kind.__name__} needs the rigid body first, not {first.name}")


def _rubbing_behind(gear: Transmission, context: Context) -> Transmission:
    # The equation of motion needs friction that brakes.
    coulomb, viscous = (
        max(gear.bearing * f(gear.joint), 0.0) for f in (context.coulomb, context.viscous)
    )
    width = max(context.sign_width(gear.joint), LEAST_WIDTH)
    return dataclasses.replace(gear, rubbing=Rubbing(coulomb, width, viscous))


def _spring(context: Context, target: Target, values: tuple[float, ...]) -> Transmission:
    frequency, damping, rotor_share, bearing, stiffening = values
    linear = _gear(JointElasticity, context, target, frequency, damping, rotor_share, 0.0, bearing)
    bend = peak_torque(context, linear.joint) / linear.stiffness
    return dataclasses.replace(linear, stiffening=stiffening / bend**2)


def _play(context: Context, target: Target, values: tuple[float, ...]) -> Transmission:
    gap, frequency, damping, rotor_share, bearing = values
    return _gear(Backlash, context, target, frequency, damping, rotor_share, gap, bearing)


def _has_play(
    context: Context,
    target: Target,
    values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    """A gap far below what the gear gives way under load is no gap that torque could tell."""
    unfit = by_construction(context, target, values, estimates)
    if unfit is not None:
        return unfit
    gear = _play(context, target, values)
    bend = 2 * float(context.peak_torque[gear.joint]) / gear.stiffness
    if gear.gap >= LEAST_PLAY * bend:
        return None
    return f"the gap, {gear.gap:.2g} rad, is {gear.gap / bend:.2g} of what the gear gives way"


def _change_by(gear: Callable[[Context, Target, tuple[float, ...]], Transmission]) -> Build:
    return lambda context, target, values: TransmissionChange(gear(context, target, values))


def _with_gear(gear: Callable[[Context, Target, tuple[float, ...]], Transmission]) -> Install:
    def install(
        context: Context,
        target: Target,
        values: tuple[float, ...],
        _estimates: Float[ndarray, " columns"],
    ) -> TorqueModel:
        seen = (gear(context, target, values), *context.model.measurement)
        return dataclasses.replace(context.model, measurement=seen)

    return install


JOINT_ELASTICITY = CatalogueEntry(
    name="joint_elasticity",
    scope="joint",
    shapes=(
        Shape("frequency", "Hz", 2.0, 40.0, "log", 12, 8.0),
        Shape("damping", "1", 0.005, 0.5, "log", 3, 0.05),
        Shape("rotor_share", "1", 0.0, 0.8, "linear", 1, 0.4),
        Shape("bearing", "1", 0.0, 1.0, "linear", 1, 0.0),
        Shape("stiffening", "1", 0.0, 30.0, "signed log", 1, 0.0, linear_below=1.0, plain=True),
    ),
    build=_change_by(_spring),
    plausible=by_construction,
    install=_with_gear(_spring),
    unit_coefficient=True,
    page=EffectPage(
        equation="τ = H(q - δ e_j) + R(q) - R(q - δ e_j), "
        "K (δ + k δ³) + D δ' + (M_jj - J) δ'' = H_j(q) - R_j(q), k = 0 where the data ask for no more, "
        "R the torque of the rotor, a body of inertia J that the rigid arm counts with link j; "
        "ω² = K / (M_jj - J); a share of the joint's friction behind the spring, at q' - δ'",
        source="Spong 1987, J. Dynamic Systems, Measurement, and Control 109(4), 310-318; Pham, "
        "Gautier, Poignet 2001, IEEE Int. Conf. Robotics and Automation; k: Tuttle and Seering 1996, "
        "IEEE Trans. Robotics and Automation 12(3), 368-374",
        parameters="ω/2π 2.5 to 20 Hz, of the arm on the spring with its motor held; ζ; stiffening "
        "k (τ_max/K)², τ_max the joint's largest torque in the recordings; the "
        "rotor's share of the inertia, and what it has beside that as it turns faster than the joint "
        "(geared_rotor, in kg m²), where the data tell it; the share of friction behind the spring",
        signature="residual grows with the square of frequency, then rings, also at other joints",
        confused_with=("filter_lag", "time_delay", "rotor_inertia"),
        exposed_by="a broad band of frequencies; an encoder on the link",
    ),
)


BACKLASH = CatalogueEntry(
    name="backlash",
    scope="joint",
    shapes=(
        Shape("gap", "rad", 1e-4, 0.02, "log", 7, 1e-3, open_below=True),
        Shape("frequency", "Hz", 5.0, 80.0, "log", 1, 20.0, also=(60.0,)),
        Shape("damping", "1", 0.05, 1.0, "log", 1, 0.3),
        Shape("rotor_share", "1", 0.0, 0.8, "linear", 1, 0.4, also=(0.2,)),
        # Most friction is the motor's, and where the links stand still in a gap hangs on the rest.
        Shape("bearing", "1", 0.0, 1.0, "linear", 1, 0.5, also=(0.1, 0.25)),
    ),
    build=_change_by(_play),
    plausible=_has_play,
    install=_with_gear(_play),
    unit_coefficient=True,
    page=EffectPage(
        equation="τ as for joint_elasticity, with K (δ ∓ gap/2) + D δ' on a flank and nothing within "
        "the gap, and a share of the joint's friction behind it, at the links' speed q' - δ'",
        source="Nordin and Gutman 2002, Automatica 38(10), 1633-1649",
        parameters="gap 0.1 to 20 mrad; ω/2π of the arm on a flank, and its ζ; the rotor's share of "
        "the inertia, and geared_rotor as for joint_elasticity; the share of friction behind the gear",
        signature="a step and a blow where the load changes its sign, also at other joints",
        confused_with=("presliding_hysteresis", "joint_elasticity"),
        exposed_by="load that reverses while the motion does not",
    ),
)
