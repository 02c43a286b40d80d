"""An elastic joint: resonance on the rigid-body torque and on nothing else."""

import numpy as np
import pytest

from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.elasticity import JointElasticity
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from tests.dynamics.effects.arms import context_of, scara, smooth_motion, vertical_arm

FREQUENCY, DAMPING = 8.0, 0.1


def _gain(w: float) -> complex:
    omega = 2 * np.pi * FREQUENCY
    s = 1j * w / omega
    return (1 + 2 * DAMPING * s) / (1 + 2 * DAMPING * s + s**2)


@pytest.mark.parametrize("hertz", [1.0, 4.0, 8.0, 12.0])
def test_rigid_torque_resonates(hertz: float) -> None:
    w, t = 2 * np.pi * hertz, np.arange(0, 6, 5e-4)
    q = np.stack([np.zeros(len(t)), 0.01 * np.sin(w * t)], axis=1)
    dq = np.stack([np.zeros(len(t)), 0.01 * w * np.cos(w * t)], axis=1)
    motion = Motion(t, q, dq, -(w**2) * q)
    model = TorqueModel.standard(scara())
    spring = JointElasticity(1, FREQUENCY, DAMPING, rigid_columns=20)
    column = 19  # Izz_2: pure acceleration on joint 2
    seen = model.with_measurement(spring).columns(motion)[:, 1, column]
    basis = np.stack([np.cos(w * t), np.sin(w * t)], axis=1)[t > 2]
    cosine, sine = np.linalg.lstsq(basis, seen[t > 2], rcond=None)[0]
    expected = _gain(w) * 1j * w**2 * 0.01  # of -w^2 sin(w t), as a phasor of cos(w t)
    assert abs(complex(cosine, -sine) - expected) < 5e-3 * abs(expected)


def test_friction_and_other_joints_do_not_pass_the_spring() -> None:
    model = TorqueModel.standard(vertical_arm())
    motion = smooth_motion(model.robot)
    spring = JointElasticity(1, FREQUENCY, DAMPING, rigid_columns=20)
    seen, rigid = model.with_measurement(spring).columns(motion), model.columns(motion)
    assert np.array_equal(seen[:, 0], rigid[:, 0])
    assert np.array_equal(seen[:, 1, 20:], rigid[:, 1, 20:])
    assert not np.allclose(seen[:, 1, :20], rigid[:, 1, :20])


def test_a_stiff_joint_adds_the_second_derivative_of_the_torque() -> None:
    context = context_of(vertical_arm(), smooth_motion(vertical_arm(), step=1e-3))
    motion = smooth_motion(vertical_arm(), step=1e-3)
    effect = CATALOGUE["joint_elasticity"].build(context, 1, (10.0, 0.005))
    change = TorqueModel(context.model.robot, (effect,)).columns(motion)[:, 1, 0]
    rigid = context.reference.parts(motion)[:, 1, 0]
    second = np.gradient(np.gradient(rigid, motion.t), motion.t)
    expected = -second / (2 * np.pi * 10.0) ** 2
    inside = slice(3000, -100)  # what rings from the start has not died out before
    share = np.dot(change[inside], expected[inside]) / np.dot(expected[inside], expected[inside])
    assert share == pytest.approx(1.0, abs=0.1)


def test_exact_form_and_column_agree() -> None:
    motion = smooth_motion(vertical_arm())
    context = context_of(vertical_arm(), motion)
    entry = CATALOGUE["joint_elasticity"]
    effect = entry.build(context, 1, (6.0, 0.1))
    exact = entry.apply(context, 1, (6.0, 0.1), np.ones(1)).torque(context.parameters, motion)
    linear = context.model.with_effects(effect).torque(np.append(context.parameters, 1.0), motion)
    assert linear == pytest.approx(exact, abs=1e-9)


def test_refuses_a_spring_without_damping() -> None:
    with pytest.raises(ValueError, match="damping"):
        JointElasticity(0, 5.0, 0.0)
