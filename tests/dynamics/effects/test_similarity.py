"""Which effects a motion tells apart once the base model has had its share."""

import numpy as np
import pytest

from oed.dynamics.effects.catalogue import CATALOGUE, Context
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.torque_model import TorqueModel
from tests.dynamics.effects.arms import (
    context_of,
    parameters_of,
    scara,
    smooth_motion,
    vertical_arm,
)
from tests.dynamics.effects.similarity import effect_angles, equivalence_classes, principal_angles


def _rows(context: Context, name: str, target, values: tuple[float, ...] = ()) -> np.ndarray:
    motion = smooth_motion(context.model.robot, step=0.01)
    effect = CATALOGUE[name].build(context, target, values)
    return evaluate(effect, motion, 2).reshape(2 * len(motion), -1)


@pytest.fixture(scope="module")
def vertical() -> Context:
    return context_of(vertical_arm())


@pytest.fixture(scope="module")
def base(vertical: Context) -> np.ndarray:
    return vertical.model.regressor(smooth_motion(vertical.model.robot, step=0.01))


def test_angle_between_vectors_modulo_a_third() -> None:
    base = np.array([[0.0], [0.0], [1.0], [0.0]])
    first = np.array([[1.0], [0.0], [7.0], [0.0]])
    second = np.array([[np.cos(0.3)], [np.sin(0.3)], [-2.0], [0.0]])
    likeness = principal_angles(base, first, second)
    assert likeness.angles == pytest.approx([0.3])
    tiny = principal_angles(base, first, first + 1e-6 * np.array([[0.0], [0.0], [0.0], [1.0]]))
    assert tiny.largest == pytest.approx(1e-6, rel=1e-3)


def test_offset_is_asymmetric_coulomb_friction(vertical: Context, base: np.ndarray) -> None:
    motion = smooth_motion(vertical.model.robot, step=0.01)
    forward = np.zeros((len(motion), 2, 1))
    forward[:, 0, 0] = motion.dq[:, 0] > 0
    likeness = principal_angles(base, _rows(vertical, "torque_offset", 0), forward.reshape(-1, 1))
    assert likeness.largest < 1e-6


def test_a_small_delay_is_a_lag_and_not_a_stribeck_curve() -> None:
    robot = vertical_arm()
    model = TorqueModel.standard(robot, sign_width=0.1)
    motion = smooth_motion(robot, step=5e-3)
    context = Context.of(model, parameters_of(model), [motion])
    delay, lag, stribeck = (
        evaluate(CATALOGUE[name].build(context, target, values), motion, 2).reshape(-1, 1)
        for name, target, values in (
            ("time_delay", None, (1e-3,)),
            ("filter_lag", None, (1e-3, 0.0)),
            ("stribeck", 0, (0.1, 2.0, 0.0)),
        )
    )
    base = model.regressor(motion)
    assert principal_angles(base, delay, lag).largest < 0.05
    assert principal_angles(base, delay, stribeck).largest > 0.5


def test_angles_over_recordings_weigh_joints_by_their_noise(vertical: Context) -> None:
    motion = smooth_motion(vertical.model.robot, step=0.01)
    halves = [motion[:500], motion[500:]]
    tilt = CATALOGUE["gravity_direction"].build(vertical, None, ())
    spring = CATALOGUE["joint_spring"].build(vertical, 0, (1.0,))
    whole = effect_angles(vertical.model, tilt, spring, [motion], np.ones(2))
    parted = effect_angles(vertical.model, tilt, spring, halves, np.ones(2))
    assert parted.angles == pytest.approx(whole.angles, abs=1e-6)
    weighed = effect_angles(vertical.model, tilt, spring, [motion], np.array([1.0, 10.0]))
    assert abs(weighed.largest - whole.largest) > 1e-3


def test_gains_of_a_two_joint_arm_are_one_class(vertical: Context, base: np.ndarray) -> None:
    gains = {str(j): _rows(vertical, "torque_gain", j, (1.0,)) for j in (0, 1)}
    assert equivalence_classes(base, gains, 1e-4) == (("0", "1"),)


def test_rotor_inertia_of_the_first_joint_is_absorbed(vertical: Context, base: np.ndarray) -> None:
    likeness = principal_angles(
        base, _rows(vertical, "rotor_inertia", 0), _rows(vertical, "stribeck", 0, (0.1, 2.0, 0.0))
    )
    assert likeness.left[0] < 1e-7
    assert len(likeness.angles) == 0


def test_a_tilt_within_the_plane_of_a_two_joint_arm_is_absorbed() -> None:
    context = context_of(vertical_arm())
    base = context.model.regressor(smooth_motion(context.model.robot, step=0.01))
    tilt = _rows(context, "gravity_direction", None)
    alone = principal_angles(base, tilt, tilt)
    assert len(alone.angles) <= 1


def test_classes_keep_different_effects_apart() -> None:
    context = context_of(scara())
    base = context.model.regressor(smooth_motion(scara(), step=0.01))
    effects = {
        "offset": _rows(context, "torque_offset", 0),
        "twice the offset": 2 * _rows(context, "torque_offset", 0),
        "stribeck": _rows(context, "stribeck", 0, (0.1, 2.0, 0.0)),
        "offset of the other": _rows(context, "torque_offset", 1),
    }
    classes = equivalence_classes(base, effects, 1e-3)
    assert classes == (("offset", "twice the offset"), ("stribeck",), ("offset of the other",))
