"""What measurement does to the whole torque, or to one joint's rigid-body torque or angle."""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.context import Context
from oed.dynamics.effects.delay import FilterLag, TimeDelay
from oed.dynamics.effects.encoder import EccentricityColumns, EncoderEccentricity
from oed.dynamics.effects.entries.plausibility import at_most, by_construction, joint_of
from oed.dynamics.effects.entry import CatalogueEntry, EffectPage, Shape, Target
from oed.dynamics.effects.gravity import (
    LEVEL,
    STANDARD_GRAVITY,
    GravityDirection,
    tilt_between,
    tilt_directions,
    tilted,
)
from oed.dynamics.effects.rigid_body import RigidBody
from oed.dynamics.effects.torque_change import TorqueChange
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import Robot


def _delay(context: Context, _target: Target, values: tuple[float, ...]) -> TorqueChange:
    return TorqueChange(TimeDelay(values[0]), context.reference)


def _with_delay(
    context: Context,
    _target: Target,
    values: tuple[float, ...],
    _estimates: Float[ndarray, " columns"],
) -> TorqueModel:
    return context.model.with_measurement(TimeDelay(values[0]))


TIME_DELAY = CatalogueEntry(
    name="time_delay",
    scope="arm",
    # A torque comes first where it was commanded, or where positions were filtered; longer than
    # that no loop would be stable.
    shapes=(Shape("delay", "s", -0.05, 0.12, "signed log", 20, 3e-3, linear_below=3e-4),),
    build=_delay,
    plausible=by_construction,
    install=_with_delay,
    unit_coefficient=True,
    equivalent=("filter_lag of the same time constant, to first order in frequency",),
    page=EffectPage(
        equation="τ_recorded(t) = τ(t - d) ≈ τ - d dτ/dt",
        source="Ljung 1999, System Identification, section 10.3; Hollerbach, Khalil, Gautier 2008, "
        "Springer Handbook of Robotics, chapter 14",
        parameters="d 0.3 to 100 ms, one for all joints; below zero where the torque comes first, "
        "as a commanded one does, or the position late",
        signature="residual like the torque's derivative, spikes at every reversal",
        confused_with=("filter_lag", "presliding_hysteresis", "joint_elasticity"),
        exposed_by="motions of 8 to 15 harmonics",
    ),
)


def _lag(context: Context, _target: Target, values: tuple[float, ...]) -> TorqueChange:
    return TorqueChange(FilterLag(values[0], values[1]), context.reference)


def _with_lag(
    context: Context,
    _target: Target,
    values: tuple[float, ...],
    _estimates: Float[ndarray, " columns"],
) -> TorqueModel:
    return context.model.with_measurement(FilterLag(values[0], values[1]))


FILTER_LAG = CatalogueEntry(
    name="filter_lag",
    scope="arm",
    shapes=(
        Shape("time_constant", "s", 2e-4, 0.05, "log", 12, 3e-3),
        Shape("curvature", "1", 0.0, 0.5, "linear", 2, 0.0, plain=True),
    ),
    build=_lag,
    plausible=by_construction,
    install=_with_lag,
    unit_coefficient=True,
    equivalent=("time_delay of the same size, to first order in frequency",),
    page=EffectPage(
        equation="τ_recorded = τ / (1 + T s + κ T² s²)",
        source="Ljung 1999, System Identification, section 4.2",
        parameters="T 0.3 to 15 ms, one for all joints; κ 0 (first order), 1/4 (two equal lags), "
        "1/2 (Butterworth)",
        signature="residual like the torque's derivative, edges rounded",
        confused_with=("time_delay", "presliding_hysteresis", "stribeck"),
        exposed_by="motions of 8 to 15 harmonics, reversals of unequal size",
    ),
)


# Waves of an angle's error, by its formula: a disc off centre, a tilted one, and from the third on
# both, or the first with one of several poles or of signals whose interpolation errs.
MOST_WAVES = 12  # periods a turn
WAVES = {1.0: (1.0,), 2.0: (2.0,)} | {n + 1.0: (1.0, float(n)) for n in range(2, MOST_WAVES + 1)}
SCANNED = tuple(formula for formula in WAVES if formula > 1)  # in a first scan besides the first


def _eccentricity(
    context: Context, target: Target, values: tuple[float, ...]
) -> EccentricityColumns:
    return EccentricityColumns(joint_of(target), context.reference, WAVES[values[0]])


def _eccentricity_plausible(
    _context: Context,
    _target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    amplitude = float(np.linalg.norm(estimates))
    return at_most(amplitude, 0.05, "the angle's error", "rad", "what any joint would show")


def _with_eccentricity(
    context: Context,
    target: Target,
    values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> TorqueModel:
    """Before what is installed; a further step of the same waves adds to them."""
    joint, harmonics, measured = joint_of(target), WAVES[values[0]], context.model.measurement
    first = measured[0] if measured else None
    waves = np.asarray(estimates, dtype=float)
    if isinstance(first, EncoderEccentricity) and (first.joint, first.harmonics) == (
        joint,
        harmonics,
    ):
        waves, measured = waves + first.waves, measured[1:]
    error = EncoderEccentricity(joint, tuple(waves.tolist()), harmonics)
    return dataclasses.replace(context.model, measurement=(error, *measured))


ENCODER_ECCENTRICITY = CatalogueEntry(
    name="encoder_eccentricity",
    scope="joint",
    shapes=(Shape("formula", "1", 1.0, max(WAVES), "formula", 1, 1.0, also=SCANNED),),
    build=_eccentricity,
    plausible=_eccentricity_plausible,
    install=_with_eccentricity,
    page=EffectPage(
        equation="H at q + a sin q + b cos q (formula 1), of 2 q instead (2), or beside another "
        "wave of n q (n + 1), where the data ask for it",
        source="Hanselman 1990, IEEE Trans. Industrial Electronics 37(6), 556-561",
        parameters="a, b in rad, amplitude 1e-4 to 1e-3: once a turn of a disc off centre, twice "
        "of a tilted one, n = 2 to 12 of poles, or of signals whose interpolation errs",
        signature="a wave in position whose size grows with the square of velocity",
        confused_with=("torque_ripple", "position_dependent_friction", "gravity_direction"),
        exposed_by="the same positions at two speeds",
    ),
)


# Some tilt along every direction: which parameters it makes visible does not depend on the angle.
SLANTED = np.array([0.3, 0.4, 0.5])


def _gravity(context: Context, _target: Target, _values: tuple[float, ...]) -> GravityDirection:
    directions, magnitude = tilt_directions(context.reference.robot.gravity)
    return GravityDirection(context.reference, directions, magnitude, _unseen(context.model))


def _unseen(model: TorqueModel) -> tuple[int, ...]:
    """Base columns of a tilted rigid body that a level one lacks, where gravity moves no joint.

    An arm whose joints feel some gravity shows nearly all its first moments as it is. The rest,
    of the links that turn about the vertical, would blur a large tilt more than they help.
    """
    robot = model.robot
    if _feels_gravity(robot):
        return ()
    directions = len(tilt_directions(robot.gravity)[0])
    turned = robot.with_gravity(tilted(robot.gravity, SLANTED[:directions]))
    level, slanted = (
        set(base_parameters(TorqueModel(r, (RigidBody(r),))).columns) for r in (robot, turned)
    )
    return tuple(int(k) for k in sorted(slanted - level))


def _feels_gravity(robot: Robot) -> bool:
    angles = np.linspace(-1.0, 1.0, 3 * robot.n).reshape(3, robot.n)
    rest = np.zeros_like(angles)
    columns = TorqueModel(robot, (RigidBody(robot),)).columns(
        Motion(np.arange(3.0), angles, rest, rest)
    )
    return bool(np.abs(columns).max() > 1e-9)


def standing(model: TorqueModel) -> TorqueModel:
    """A model of an arm that is declared weightless because its axes are all upright, under gravity.

    Along them gravity moves no joint: the torque is the same, and a tilt has a direction to start
    from. Any other arm is left as it is.
    """
    robot = model.robot
    first = robot.joints[robot.outward[0]]
    axis = first.R_PJ @ first.axis
    up = axis * np.sign(axis[np.argmax(np.abs(axis))])
    under = robot.with_gravity(-STANDARD_GRAVITY * up)
    if np.linalg.norm(robot.gravity) >= LEVEL or _feels_gravity(under):
        return model
    return model.with_robot(under)


def _tilt(robot: Robot, estimates: Float[ndarray, " columns"]) -> Float[ndarray, " directions"]:
    return estimates[: len(tilt_directions(robot.gravity)[0])]


def _gravity_plausible(
    context: Context,
    _target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    tilt = float(np.linalg.norm(_tilt(context.model.robot, estimates)))
    return at_most(tilt, 2.0, "the tilt", "rad", "what one linear step can mean")


def _with_gravity(
    context: Context,
    _target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> TorqueModel:
    robot = context.model.robot
    turned = robot.with_gravity(tilted(robot.gravity, _tilt(robot, estimates)))
    return context.model.with_robot(turned)


def _tilt_in(base: TorqueModel, model: TorqueModel) -> Float[ndarray, " directions"]:
    """Turns do not add up: the second is about axes that the first has turned."""
    return tilt_between(base.robot.gravity, model.robot.gravity)


def _has_turning_joints(context: Context) -> bool:
    """Whether gravity turns in some link: along sliding joints alone a tilt is an offset."""
    return any(joint.kind == "revolute" for joint in context.model.robot.joints)


GRAVITY_DIRECTION = CatalogueEntry(
    name="gravity_direction",
    scope="arm",
    shapes=(),
    build=_gravity,
    plausible=_gravity_plausible,
    install=_with_gravity,
    size_in=_tilt_in,
    sets_apart=_has_turning_joints,
    equivalent=("a tilt within the plane of a vertical two-joint arm: a shift of its first angle",),
    page=EffectPage(
        equation="Σ_k tilt_k ∂τ/∂g · e_k |g|, e_k at right angles to the declared gravity",
        source="Luh, Walker, Paul 1980, J. Dynamic Systems, Measurement, and Control 102(2), 69-76; "
        "Atkeson, An, Hollerbach 1986, Int. J. Robotics Research 5(3)",
        parameters="tilts in rad, 0.3° to 90°; larger ones by repeating the step from the new "
        "direction",
        signature="sines of summed angles, in the rows of all joints at once",
        confused_with=("joint_spring", "torque_offset", "payload_change"),
        exposed_by="wide ranges of the joints whose axes are not vertical",
    ),
)
