"""A tilted base is the same arm under turned gravity."""

import numpy as np
import pytest
from numpy import ndarray

from oed.dynamics.effects.catalogue import CATALOGUE, Context
from oed.dynamics.effects.entries.measurement import standing
from oed.dynamics.effects.gravity import (
    GravityDirection,
    tilt_between,
    tilt_directions,
    tilted,
)
from oed.dynamics.newton_euler import rigid_body_torque
from oed.dynamics.torque_model import TorqueModel
from oed.robot.builtin import imi_scara
from tests.dynamics.effects.arms import context_of, panda, parameters_of, scara, smooth_motion


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (0.0, -9.81, 0.0), (3.0, -4.0, 5.0)])
def test_directions_turn_gravity_and_do_not_stretch_it(gravity: tuple) -> None:
    g = np.array(gravity)
    directions, magnitude = tilt_directions(g)
    axes = np.array(directions)
    assert magnitude == pytest.approx(np.linalg.norm(g))
    assert axes @ axes.T == pytest.approx(np.eye(2), abs=1e-12)
    assert axes @ g == pytest.approx(np.zeros(2), abs=1e-12)
    turned = tilted(g, np.array([0.3, -0.4]))
    assert np.linalg.norm(turned) == pytest.approx(magnitude)
    assert np.arccos(turned @ g / magnitude**2) == pytest.approx(0.5)


@pytest.mark.parametrize("tilt", [(0.02, -0.01), (1.5, 0.3), (0.0, -3.0)])
def test_the_tilt_between_two_gravities_is_the_one_that_turned_them(tilt: tuple) -> None:
    declared = np.array([3.0, -4.0, 5.0])
    assert tilt_between(declared, tilted(declared, np.array(tilt))) == pytest.approx(tilt)


def test_columns_are_the_change_of_newton_euler_torque() -> None:
    robot, change = panda(), np.array([0.7, -1.1, 0.4])
    motion = smooth_motion(robot, step=0.1)
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    effect = GravityDirection(context_of(robot, motion).reference, axes, magnitude=1.0)
    columns = TorqueModel(robot, (effect,)).columns(motion)
    turned = robot.with_gravity(robot.gravity + change)
    expected = rigid_body_torque(turned, motion) - rigid_body_torque(robot, motion)
    assert columns @ change == pytest.approx(expected, abs=1e-10)


def _fit(model: TorqueModel, torque: np.ndarray, motion) -> np.ndarray:
    return np.linalg.lstsq(model.regressor(motion), torque.ravel(), rcond=1e-10)[0]


@pytest.mark.parametrize("degrees", [0.5, 90.0])
def test_repeated_steps_reach_a_tilt_of_any_size(degrees: float) -> None:
    robot = panda()
    motion = smooth_motion(robot, step=0.1)
    angle = np.deg2rad(degrees)
    true = robot.with_gravity(9.81 * np.array([np.sin(angle), 0.0, -np.cos(angle)]))
    truth = TorqueModel.standard(true)
    torque = truth.torque(parameters_of(truth), motion)
    model, entry = TorqueModel.standard(robot), CATALOGUE["gravity_direction"]
    for _ in range(25):
        context = Context.of(model, _fit(model, torque, motion), [motion])
        effect = entry.build(context, None, ())
        first = len(model.parameters)
        tilt = _fit(model.with_effects(effect), torque, motion)[first : first + 2]
        if np.linalg.norm(tilt) < 1e-4:
            break
        # As far as one linear step can mean.
        tilt *= min(1.0, 1.0 / np.linalg.norm(tilt))
        model = entry.apply(context, None, (), tilt)
    assert model.robot.gravity == pytest.approx(true.gravity, abs=1e-3)


def test_an_arm_declared_weightless_can_be_given_any_gravity() -> None:
    robot = scara().with_gravity(np.zeros(3))
    context = context_of(robot)
    entry = CATALOGUE["gravity_direction"]
    effect = entry.build(context, None, ())
    assert [p.name for p in effect.parameters[:3]] == ["tilt_1", "tilt_2", "tilt_3"]
    model = entry.apply(context, None, (), np.array([0.0, -1.0, 0.0]))
    assert model.robot.gravity == pytest.approx([0.0, -9.80665, 0.0])


def test_a_level_arm_shows_its_first_moments_when_it_is_tilted() -> None:
    robot = scara()
    motion = smooth_motion(robot, step=0.05)
    angle = np.deg2rad(2.0)
    true = TorqueModel.standard(
        robot.with_gravity(9.81 * np.array([np.sin(angle), 0.0, -np.cos(angle)]))
    )
    torque = true.torque(parameters_of(true), motion)
    model = TorqueModel.standard(robot)
    first = len(model.parameters)

    def refined(parameters: ndarray) -> tuple[TorqueModel, ndarray]:
        context = Context.of(model, parameters, [motion])
        effect = CATALOGUE["gravity_direction"].build(context, None, ())
        with_effect = model.with_effects(effect)
        return with_effect, _fit(with_effect, torque, motion)

    # Its columns hold for the parameters known so far, which the tilt itself has spoilt.
    with_effect, found = refined(_fit(model, torque, motion))
    for _ in range(7):
        with_effect, found = refined(found[:first])
    # Linear in the sine of the tilt, so that nothing is left but rounding.
    assert with_effect.torque(found, motion) == pytest.approx(torque, abs=1e-9)
    assert found[first : first + 2] == pytest.approx([np.sin(angle), 0.0], abs=1e-6)


def test_a_weightless_arm_with_upright_axes_stands_under_gravity() -> None:
    flat = scara().with_gravity(np.zeros(3))
    under = standing(TorqueModel.standard(flat)).robot
    assert np.linalg.norm(under.gravity) == pytest.approx(9.81, abs=0.01)
    motion = smooth_motion(flat, step=0.1)
    assert rigid_body_torque(under, motion) == pytest.approx(rigid_body_torque(flat, motion))
    # Whose joints gravity would move floats, as it is declared to.
    afloat = TorqueModel.standard(panda().with_gravity(np.zeros(3)))
    assert standing(afloat) is afloat


@pytest.mark.parametrize("declared", [(0, 0, -9.81), (9.81, 0, 0), (0, 9.81, 0), (0, 6.9, -6.9)])
def test_a_turned_gravity_has_nearly_the_same_directions(declared) -> None:
    g = np.array(declared, dtype=float)
    first, _ = tilt_directions(g)
    for tilt in ((0.03, 0.05), (-0.05, 0.02), (0.01, -0.06)):
        second, _ = tilt_directions(tilted(g, np.array(tilt)))
        assert np.sum(np.array(first) * np.array(second), axis=1) == pytest.approx(1, abs=0.01)


def test_the_size_of_two_turns_is_that_of_the_whole_turn() -> None:
    robot = imi_scara().with_gravity(np.array([0.0, 0.0, -9.81]))
    base = TorqueModel.standard(robot)
    once = base.with_robot(robot.with_gravity(tilted(robot.gravity, np.array([0.4, 0.1]))))
    twice = once.with_robot(robot.with_gravity(tilted(once.robot.gravity, np.array([-0.1, 0.5]))))
    read = CATALOGUE["gravity_direction"].size_in
    assert read is not None
    size = read(base, twice)
    # Not the sum of both: the second is about axes that the first has turned.
    assert tilted(robot.gravity, size) == pytest.approx(twice.robot.gravity)
    assert np.abs(size - [0.3, 0.6]).max() > 0.01
