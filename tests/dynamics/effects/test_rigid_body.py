"""The rigid body's columns along motions that are asked for again."""

import dataclasses
import pickle

import numpy as np

from oed.dynamics.effects import RigidBody, State, rigid_body
from oed.dynamics.newton_euler import filled, rigid_body_regressor
from tests.dynamics.effects.arms import scara, smooth_motion

ROBOT = scara()


def columns(effect, motion):
    return filled(effect.entries(State.along(motion)), len(motion), ROBOT.n)


def test_entries_are_worked_out_once_for_a_motion(monkeypatch) -> None:
    effect, motion = RigidBody(ROBOT), smooth_motion(ROBOT)
    expected = rigid_body_regressor(ROBOT, motion)
    np.testing.assert_array_equal(columns(effect, motion), expected)
    monkeypatch.delattr(rigid_body, "regressor_entries")
    again = dataclasses.replace(motion, q=motion.q.copy())
    np.testing.assert_array_equal(columns(effect, again), expected)


def test_motions_that_differ_in_one_sample_have_columns_of_their_own() -> None:
    effect, motion = RigidBody(ROBOT), smooth_motion(ROBOT)
    columns(effect, motion)
    other = dataclasses.replace(motion, ddq=motion.ddq.copy())
    other.ddq[3, 1] += 0.1
    np.testing.assert_array_equal(columns(effect, other), rigid_body_regressor(ROBOT, other))


def test_what_is_remembered_is_bounded_and_told_to_nobody(monkeypatch) -> None:
    effect, motion = RigidBody(ROBOT), smooth_motion(ROBOT)
    columns(effect, motion)
    size = len(pickle.dumps(effect))
    assert size == len(pickle.dumps(RigidBody(ROBOT)))
    monkeypatch.setattr(rigid_body, "KEPT_BYTES", 0)
    columns(effect, motion[1:])
    assert not effect._memory
