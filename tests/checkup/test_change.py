"""Changes of a log, one after another."""

import numpy as np
import pytest

from oed.checkup.change import Change
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from tests.checkup.arm import robot

ONE = Change((1, 0, 2), (2.0, -1.0, 1.0), (2, 0, 1), (1.0, -1.0, 1.0), (1.0, 2.0, 3.0))
OTHER = Change((0, 2, 1), (1.0, 3.0, -1.0), (1, 0, 2), (-1.0, 1.0, 1.0))


@pytest.fixture
def rows():
    return np.random.default_rng(3).normal(size=(5, 3))


@pytest.mark.parametrize(("first", "then"), [(ONE, OTHER), (OTHER, ONE), (ONE, ONE)])
def test_two_changes_are_what_one_after_the_other_is(rows, first, then):
    both = first.then(then)
    np.testing.assert_allclose(both.torque(rows), then.torque(first.torque(rows)))
    motion = Motion(np.arange(5.0), rows, 2 * rows, 3 * rows)
    moved, expected = both.motion(motion), then.motion(first.motion(motion))
    for field in ("q", "dq", "ddq"):
        np.testing.assert_allclose(getattr(moved, field), getattr(expected, field))
    assert both.gravity == (then.gravity or first.gravity)


def test_what_is_said_of_a_joint_is_of_the_column_that_its_torque_is_taken_from():
    of_joints = np.array([5.0, 6.0, 7.0])
    by_column = Change((2, 0, 1), (1.0,) * 3, (0, 1, 2), (1.0,) * 3).by_column(of_joints)
    np.testing.assert_array_equal(by_column, [6.0, 7.0, 5.0])


def test_no_change_changes_nothing(rows):
    none = Change.none(3)
    np.testing.assert_array_equal(none.torque(rows), rows)
    assert not none.moves
    assert none.then(ONE) == ONE
    assert ONE.then(none) == ONE


@pytest.mark.parametrize(
    ("gain", "turn", "agree"),
    [
        ((-1.0, 1.0, 1.0), (1.0, 1.0, 1.0), True),  # the torque's sign in place of the position's
        ((1.0, -1.0, -1.0), (1.0, 1.0, 1.0), True),  # with all signs of the torques reversed
        ((1.0, -1.0, 1.0), (1.0, 1.0, 1.0), False),
        ((-2.0, 1.0, 1.0), (1.0, 1.0, 1.0), False),
    ],
)
def test_signs_agree_up_to_those_of_all_torques_and_of_both_of_a_joint(gain, turn, agree):
    same = (0, 1, 2)
    position = Change(same, (1.0, 1.0, 1.0), same, (-1.0, 1.0, 1.0))
    assert position.differs_in_signs(Change(same, gain, same, turn)) is agree


def test_gravity_is_the_declared_one_unless_it_is_changed():
    model = build_model("standard", robot())
    assert OTHER.model(model) is model
    np.testing.assert_array_equal(ONE.model(model).robot.gravity, [1.0, 2.0, 3.0])
