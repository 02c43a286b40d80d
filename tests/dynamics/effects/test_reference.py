"""What a reference torque remembers is what it would find anew."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects import Viscous
from oed.dynamics.effects.actuator import GainError
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.effect import State
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.effects.motor import MotorCoupling
from oed.dynamics.effects.on_reference import holds_reference
from oed.dynamics.effects.position import PositionFriction, TorqueRipple
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.motion import Motion, random_motion, with_joint
from oed.dynamics.scalars import mean_sign
from oed.robot import imi_scara
from tests.dynamics.effects.arms import context_of, smooth_motion, vertical_arm


def motion_of(samples: int) -> Motion:
    return random_motion(imi_scara(), samples, np.random.default_rng(4))


@pytest.mark.parametrize("joint", [0, 1])
def test_slopes_are_those_of_the_torque(joint):
    motion, reference = motion_of(20), ReferenceTorque(imi_scara())
    slopes = reference.slopes(State.along(motion), joint)
    for k, name in enumerate(("q", "dq", "ddq")):

        def moved(step: float, changed: str = name) -> np.ndarray:
            there = [
                getattr(motion, x)[:, joint] + step * (x == changed) for x in ("q", "dq", "ddq")
            ]
            return reference.parts(with_joint(motion, joint, there))[:, :, 0]

        expected = (moved(1e-4) - moved(-1e-4)) / 2e-4
        found = np.stack([by[k] + np.zeros(20) for by in slopes], axis=1)
        np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("joint", [0, 1])
def test_slopes_of_all_else_are_those_of_their_torque(joint):
    motion, robot = motion_of(20), imi_scara()
    others = (Viscous(0), Viscous(1), TorqueRipple(0, (3.0,)), PositionFriction(1, (1.0,)))
    others = (*others, MotorCoupling((0, 1), (1.0, -2.0)), GainError(0, ReferenceTorque(robot)))
    sizes = tuple(0.1 * k for k in range(1, 1 + sum(len(e.parameters) for e in others)))
    reference = ReferenceTorque(robot, others, sizes)
    slopes = reference.slopes_beside(State.along(motion), joint)
    own = [getattr(motion, x)[:, joint] for x in ("q", "dq", "ddq")]
    for k, way in enumerate(((1.0, 0.0, 0.0), (0.0, own[1], 0.0), (0.0, 0.0, 1.0))):

        def moved(step: float, along: tuple = way) -> np.ndarray:
            there = [x + step * d for x, d in zip(own, along, strict=True)]
            return reference.parts(with_joint(motion, joint, there))[:, :, 1]

        expected = (moved(1e-5) - moved(-1e-5)) / 2e-5
        found = np.stack([by[k] + np.zeros(20) for by in slopes], axis=1)
        np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-8)


def test_what_a_coordinate_does_not_change_leaves_no_rounding_in_the_slopes_along_it():
    state, ripple = State.along(motion_of(20)), TorqueRipple(0, (3.0,))
    alone = ReferenceTorque(imi_scara(), (ripple,), (0.1, 0.2)).slopes_beside(state, 0)
    beside = ReferenceTorque(imi_scara(), (ripple, Viscous(0)), (0.1, 0.2, 1e9))
    np.testing.assert_array_equal(beside.slopes_beside(state, 0)[0][0], alone[0][0])


def test_signs_are_remembered_by_joint_and_width():
    motion = Motion(*(getattr(motion_of(30), x) for x in ("t", "q", "dq", "ddq")), averaged=True)
    state = State.along(motion)
    for width in (0.1, 0.5, 0.1):
        for velocity in state.dq:
            np.testing.assert_array_equal(state.sign(velocity, width), mean_sign(velocity, width))
    assert state.sign(state.dq[0], 0.5) is State.along(motion).sign(state.dq[0], 0.5)
    # An array that is not the motion's may come to lie where another has been.
    for scale in (1.0, -2.0, 3.0):
        other = scale * state.dq[0]
        np.testing.assert_array_equal(state.sign(other, 0.1), mean_sign(other, 0.1))


def test_references_end_however_often_a_model_is_refitted():
    context = context_of(vertical_arm(), smooth_motion(vertical_arm(), 1.0))
    entry, sizes = CATALOGUE["load_dependent_friction"], np.array([0.08])
    effect = entry.build(context, 1, (1.0, 1.0))
    for _ in range(4):
        context = dataclasses.replace(context, beside=((effect, sizes),))
        effect = entry.build(context, 1, (1.0, 1.0))
    context = dataclasses.replace(context, beside=((effect, sizes),))
    (inner,) = [e for e in context.reference.others if holds_reference(e)]
    assert not any(holds_reference(e) for e in inner.reference.others)
    # What is left out is the share of a share of a share.
    motion = smooth_motion(vertical_arm(), 1.0)
    once = entry.build(dataclasses.replace(context, beside=()), 1, (1.0, 1.0))
    sizes_of = [np.abs(evaluate(e, motion, 2) * 0.08).max() for e in (once, effect)]
    assert sizes_of[1] == pytest.approx(sizes_of[0], rel=0.1)
    assert sizes_of[1] != sizes_of[0]
