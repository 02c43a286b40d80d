"""All that the bench can hide: every name of the catalogue, other formulas, and strangers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from studies.bench import drive_forms as drive
from studies.bench import friction_forms as friction
from studies.bench import outside_forms as outside
from studies.bench import position_forms as position
from studies.bench import stranger_forms as stranger
from studies.bench.injection import Inject

OUTSIDE = "outside"
Kind = Literal["plain", "other_formula", "outside"]


@dataclass(frozen=True)
class Form:
    """One way to hide one effect.

    Attributes:
        key: Its name in the cases.
        name: What the catalogue calls the effect; "outside" if it has no name for it.
        inject: Hides it.
        kind: Whether it is the usual formula, the same physics in another formula, or outside.
        whole_arm: Whether it concerns all joints.
        first_joint: Innermost joint at which it can be told from the rigid body.
        has_outer: Whether it needs a joint further out.
        robots: Arms on which it can show; empty for all.
    """

    key: str
    name: str
    inject: Inject
    kind: Kind = "plain"
    whole_arm: bool = False
    first_joint: int = 0
    has_outer: bool = False
    robots: tuple[str, ...] = ()


# A tilt of a vertical arm about the axes of its joints turns its gravity within its own plane,
# which its first moments absorb but for their part in the coupling of the two rows.
TILTABLE = ("scara", "ur5", "panda")
# Light wrists on springs would need a step far below a control period.
STURDY = ("scara", "vertical")

_PLAIN = (
    Form("stribeck", "stribeck", friction.stribeck),
    Form("power_of_speed", "nonlinear_viscous", friction.power_of_speed),
    Form("one_sided_viscous", "asymmetric_viscous", friction.one_sided_viscous),
    Form("constant", "torque_offset", position.constant),
    Form("dahl", "presliding_hysteresis", friction.dahl),
    Form("loose_gear", "backlash", drive.loose_gear, robots=STURDY),
    Form("load_friction", "load_dependent_friction", friction.load_friction),
    Form("position_friction", "position_dependent_friction", friction.position_friction),
    Form("ripple", "torque_ripple", position.ripple),
    Form("spring", "joint_spring", position.spring),
    Form("tilted_base", "gravity_direction", position.tilted_base, whole_arm=True, robots=TILTABLE),
    Form("rotor", "rotor_inertia", drive.rotor, first_joint=1),
    Form("neighbour_motor", "motor_coupling", drive.neighbour_motor, has_outer=True),
    Form("gain", "torque_gain", drive.gain),
    Form("rising_current", "torque_saturation", drive.rising_current),
    Form("late_torque", "time_delay", drive.late_torque, whole_arm=True),
    Form("lagging_torque", "filter_lag", drive.lagging_torque, whole_arm=True),
    Form("elastic", "joint_elasticity", drive.elastic, robots=STURDY),
    Form("cooling_start", "thermal_drift", friction.cooling_start),
    Form("payload", "payload_change", position.payload_from_then_on, whole_arm=True),
    Form("eccentric_encoder", "encoder_eccentricity", drive.eccentric_encoder),
)
_OTHER_FORMULA = (
    Form("stribeck_lorentz", "stribeck", friction.stribeck_lorentz, "other_formula"),
    Form("eyring", "nonlinear_viscous", friction.eyring, "other_formula"),
    Form(
        "rounded_one_sided_viscous",
        "asymmetric_viscous",
        friction.rounded_one_sided_viscous,
        "other_formula",
    ),
    Form("unequal_directions", "torque_offset", friction.unequal_directions, "other_formula"),
    Form("maxwell_slip", "presliding_hysteresis", friction.maxwell_slip, "other_formula"),
    Form("bouc_wen", "presliding_hysteresis", friction.bouc_wen, "other_formula"),
    Form(
        "total_load_friction",
        "load_dependent_friction",
        friction.total_load_friction,
        "other_formula",
    ),
    Form("tight_spot", "position_dependent_friction", friction.tight_spot, "other_formula"),
    Form("ripple_with_overtone", "torque_ripple", position.ripple_with_overtone, "other_formula"),
    Form("tightening_cable", "joint_spring", position.tightening_cable, "other_formula"),
    Form("squeezed_signal", "torque_saturation", drive.squeezed_signal, "other_formula"),
    Form(
        "twice_lagging_torque",
        "filter_lag",
        drive.twice_lagging_torque,
        "other_formula",
        whole_arm=True,
    ),
    Form(
        "hardening_elastic",
        "joint_elasticity",
        drive.hardening_elastic,
        "other_formula",
        robots=STURDY,
    ),
    Form("slow_warming", "thermal_drift", friction.slow_warming, "other_formula"),
    Form("oval_encoder", "encoder_eccentricity", drive.oval_encoder, "other_formula"),
)
_OUTSIDE = tuple(
    Form(function.__name__, OUTSIDE, function, "outside")
    for function in (
        outside.drag_of_a_bundle,
        outside.drag_along_the_turn,
        outside.landscape,
        outside.modulated_cogging,
        outside.fanned_drag,
        outside.shaking_floor,
        outside.dragged_hose,
    )
)
_STRANGERS = (
    Form("pumped_balancer", OUTSIDE, stranger.pumped_balancer, "outside"),
    # At the last joint the mean of its inertia would be a rotor's.
    Form("connecting_rod", OUTSIDE, stranger.connecting_rod, "outside", has_outer=True),
    Form("stray_field", OUTSIDE, stranger.stray_field, "outside"),
    Form("sliding_pad", OUTSIDE, stranger.sliding_pad, "outside"),
    Form("brake_of_its_own_mind", OUTSIDE, stranger.brake_of_its_own_mind, "outside"),
    Form("slack_tether", OUTSIDE, stranger.slack_tether, "outside"),
    Form("creeping_strap", OUTSIDE, stranger.creeping_strap, "outside"),
)
_THERMOMETERS = (Form("swinging_warmth", "thermal_drift", friction.swinging_warmth),)
FORMS = {
    form.key: form for form in (*_PLAIN, *_OTHER_FORMULA, *_OUTSIDE, *_STRANGERS, *_THERMOMETERS)
}
# Keys in the order in which they came: rounds had been run by then, so that a plan draws each wave
# apart, and the earlier ones stay the same.
WAVES = tuple(
    frozenset(form.key for form in forms)
    for forms in ((*_PLAIN, *_OTHER_FORMULA, *_OUTSIDE), _STRANGERS, _THERMOMETERS)
)


def forms_of(kind: Kind, robot: str) -> tuple[Form, ...]:
    """The forms of a kind that can show on an arm."""
    return tuple(
        form for form in FORMS.values() if form.kind == kind and robot in (form.robots or (robot,))
    )
