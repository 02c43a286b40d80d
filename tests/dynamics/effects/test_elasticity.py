"""An elastic joint, against a two-mass arm integrated with its full nonlinear equations."""

import dataclasses

import numpy as np
import pytest
from numpy import ndarray

from oed.dynamics.effects.catalogue import CATALOGUE, Context
from oed.dynamics.effects.deflection import deflect
from oed.dynamics.effects.effect import State
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.effects.rigid_body import RigidBody
from oed.dynamics.effects.transmission import JointElasticity, TransmissionChange
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import Robot
from tests.dynamics.effects.arms import (
    context_of,
    parameters_of,
    scara,
    smooth_motion,
    vertical_arm,
)
from tests.dynamics.effects.two_mass import Gear, two_mass_torque

FREQUENCY, DAMPING = 8.0, 0.1


def _seen(robot: Robot, motion: Motion, joint: int, rotor: float) -> tuple[ndarray, ndarray]:
    """Torque of the rigid arm, and through the effect."""
    rigid = RigidBody(robot)
    reference = ReferenceTorque(robot)
    posture = tuple((motion.q.min(axis=0) + motion.q.max(axis=0)) / 2)
    spring = JointElasticity(joint, FREQUENCY, DAMPING, rotor, 0.0, 0.0, posture, reference)
    model = TorqueModel(robot, (rigid,))
    sprung = model.with_measurement(spring)
    return model.torque(robot.parameters, motion), sprung.torque(robot.parameters, motion)


@pytest.mark.parametrize(("joint", "rotor"), [(0, 0.0), (0, 0.15), (1, 0.0), (1, 0.3)])
def test_every_joint_feels_the_links_on_the_spring(joint: int, rotor: float) -> None:
    robot = vertical_arm()
    motion = smooth_motion(robot, duration=2.2, step=1e-3)
    true = two_mass_torque(robot, motion, joint, Gear(FREQUENCY, DAMPING, rotor))
    rigid, seen = _seen(robot, motion, joint, rotor)
    settled = motion.t > 1.4  # the start, at speed, rings on an arm that began at rest
    error, change = (seen - true)[settled], (rigid - true)[settled]
    # What is left is of second order in a bend of some mrad.
    assert (np.linalg.norm(error, axis=0) < 0.06 * np.linalg.norm(change, axis=0)).all()


@pytest.mark.parametrize("joint", [0, 1])
def test_a_spring_may_stiffen(joint: int) -> None:
    robot, rotor = vertical_arm(), 0.2
    motion = smooth_motion(robot, duration=3.0, step=1e-3)
    reference = ReferenceTorque(robot)
    middle = (motion.q.min(axis=0) + motion.q.max(axis=0)) / 2
    spring = JointElasticity(joint, FREQUENCY, DAMPING, rotor, 0.0, 0.0, tuple(middle), reference)
    bend = np.abs(spring.bend(State.along(motion)).d).max()
    stiffer = dataclasses.replace(spring, stiffening=2 / bend**2)
    model = TorqueModel(robot, (RigidBody(robot),))
    gear = Gear(FREQUENCY, DAMPING, rotor, stiffening=stiffer.stiffening)
    true = two_mass_torque(robot, motion, joint, gear)
    rigid = model.torque(robot.parameters, motion)
    linear, found = (
        model.with_measurement(s).torque(robot.parameters, motion) for s in (spring, stiffer)
    )
    settled = motion.t > 1.4
    error, change = (found - true)[settled], (rigid - true)[settled]
    plain = (linear - true)[settled]
    # What is left is of second order in a bend of some mrad; a linear spring leaves far more.
    assert (np.linalg.norm(error, axis=0) < 0.06 * np.linalg.norm(change, axis=0)).all()
    assert (np.linalg.norm(error, axis=0) < 0.2 * np.linalg.norm(plain, axis=0)).all()


@pytest.mark.parametrize("stiffening", [5.0, 10.0, 20.0])
@pytest.mark.parametrize("frequency", [32.0, 36.0, 40.0])
def test_a_stiffer_spring_settles_at_any_step(frequency: float, stiffening: float) -> None:
    """With few steps a swing, a step by the tangent alone runs away."""
    motion = smooth_motion(vertical_arm(), duration=6.0, step=1e-2)
    context = context_of(vertical_arm(), motion)
    for joint in (0, 1):
        most = []
        for k in (0.0, stiffening):
            values = (frequency, 0.01, 0.2, 0.7, k)
            spring = CATALOGUE["joint_elasticity"].build(context, joint, values)
            assert isinstance(spring, TransmissionChange)
            most.append(np.abs(spring.gear.bend(State.along(motion)).d).max())
        # It rings elsewhere, but bends no further than the softer one but for that.
        assert 0 < most[1] < 1.5 * most[0]


@pytest.mark.parametrize("hertz", [1.0, 4.0, 8.0, 12.0])
def test_deflection_is_that_of_an_oscillator(hertz: float) -> None:
    mass, omega, w = 1.5, 2 * np.pi * FREQUENCY, 2 * np.pi * hertz
    t = np.arange(0, 6, 5e-4)
    stiffness, damper = mass * omega**2, 2 * DAMPING * omega * mass
    load, inertia, still = np.sin(w * t), np.full(len(t), mass), np.zeros(len(t))
    found = deflect(t, load, inertia, (stiffness, damper, 0.0, 0.0), (still, 0.0, 1.0, 0.0))
    phasor = 1 / (stiffness - mass * w**2 + 1j * w * damper)
    expected = [np.imag(phasor * (1j * w) ** k * np.exp(1j * w * t)) for k in range(3)]
    late = t > 3
    for series, exact in zip(found, expected, strict=True):
        # The trapezoidal rule shifts the frequency by (w step)^2 / 12.
        assert series[late] == pytest.approx(exact[late], abs=5e-3 * np.abs(exact).max())


def test_friction_of_the_motor_stays_with_it() -> None:
    model = TorqueModel.standard(vertical_arm())
    motion = smooth_motion(model.robot)
    entry, context = CATALOGUE["joint_elasticity"], context_of(vertical_arm(), motion)
    seen = entry.apply(context, 1, (FREQUENCY, DAMPING, 0.2, 0.0, 0.0), np.ones(1)).columns(motion)
    assert np.array_equal(seen[:, :, 20:], model.columns(motion)[:, :, 20:])


@pytest.mark.parametrize("bearing", [0.0, 0.6])
def test_a_part_of_a_model_is_seen_as_it_is_in_the_whole(bearing: float) -> None:
    """Wherever its columns stand: those of friction alone are not taken for the rigid body's."""
    model = TorqueModel.standard(vertical_arm())
    motion = smooth_motion(model.robot)
    entry, context = CATALOGUE["joint_elasticity"], context_of(vertical_arm(), motion)
    seen = entry.apply(context, 1, (FREQUENCY, DAMPING, 0.2, bearing, 0.0), np.ones(1))
    whole = seen.columns(motion)
    rigid, *friction = seen.effects
    turned = dataclasses.replace(seen, effects=(*friction, rigid)).columns(motion)
    assert turned == pytest.approx(np.concatenate([whole[:, :, 20:], whole[:, :, :20]], axis=2))
    alone = dataclasses.replace(seen, effects=tuple(friction)).columns(motion)
    assert alone == pytest.approx(whole[:, :, 20:])
    assert dataclasses.replace(seen, effects=()).columns(motion).shape[2] == 0


@pytest.mark.parametrize("bearing", [0.6, 1.0])
@pytest.mark.parametrize("joint", [0, 1])
def test_friction_of_the_links_acts_behind_the_spring(joint: int, bearing: float) -> None:
    robot, rotor = vertical_arm(), 0.3
    motion = smooth_motion(robot, duration=3.0, step=1e-3)
    model = TorqueModel.standard(robot, sign_width=0.01)
    parameters = parameters_of(model)
    context = Context.of(model, parameters, [motion])
    rigid = model.torque(parameters, motion)
    friction = rigid - model.torque(np.concatenate([robot.parameters, np.zeros(4)]), motion)
    gear = Gear(FREQUENCY, DAMPING, rotor, coulomb=2.0 * bearing, width=0.01, viscous=bearing)
    true = two_mass_torque(robot, motion, joint, gear) + friction
    true[:, joint] -= bearing * friction[:, joint]
    entry, values = CATALOGUE["joint_elasticity"], (FREQUENCY, DAMPING, rotor, bearing, 0.0)
    seen = entry.apply(context, joint, values, np.ones(1)).torque(parameters, motion)
    settled = motion.t > 1.4
    error, change = (seen - true)[settled], (rigid - true)[settled]
    # Of second order in a bend of some mrad, as without friction there.
    assert (np.linalg.norm(error, axis=0) < 0.06 * np.linalg.norm(change, axis=0)).all()


@pytest.mark.parametrize("joint", [0, 1])
def test_exact_form_and_column_differ_in_second_order_of_the_bend(joint: int) -> None:
    motion = smooth_motion(vertical_arm(), step=1e-3)
    context = context_of(vertical_arm(), motion)
    rigid = context.model.torque(context.parameters, motion)
    entry, shares = CATALOGUE["joint_elasticity"], []
    for frequency in (12.0, 24.0):  # a quarter of the bend
        values = (frequency, 0.1, 0.3, 0.0, 0.0)
        exact = entry.apply(context, joint, values, np.ones(1)).torque(context.parameters, motion)
        model = context.model.with_effects(entry.build(context, joint, values))
        linear = model.torque(np.append(context.parameters, 1.0), motion)
        shares.append(np.linalg.norm(linear - exact) / np.linalg.norm(exact - rigid))
    assert shares[0] < 0.03
    assert shares[1] < shares[0] / 3


def test_refuses_a_spring_without_damping() -> None:
    reference = ReferenceTorque(scara())
    good = JointElasticity(0, 5.0, 0.1, 0.0, 0.0, 0.0, (0.0, 0.0), reference)
    with pytest.raises(ValueError, match="damping"):
        dataclasses.replace(good, damping=0.0)
    with pytest.raises(ValueError, match="rotor_share"):
        dataclasses.replace(good, rotor_share=1.0)
