"""An eccentric encoder: consistent motion, and columns that are its derivatives."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.encoder import EncoderEccentricity
from tests.dynamics.effects.arms import context_of, panda, smooth_motion, vertical_arm


def test_corrected_velocity_and_acceleration_are_derivatives_of_position() -> None:
    motion = smooth_motion(vertical_arm(), step=1e-3)
    error = EncoderEccentricity(1, (5e-4, 4e-4, 2e-3, -1e-3), (1.0, 2.0))
    q, dq, ddq = error.corrected(motion.q[:, 1], motion.dq[:, 1], motion.ddq[:, 1])
    inside = slice(2, -2)
    assert dq[inside] == pytest.approx(np.gradient(q, motion.t)[inside], abs=1e-4)
    assert ddq[inside] == pytest.approx(np.gradient(dq, motion.t)[inside], abs=1e-3)


def test_amplitude_and_phase() -> None:
    q = np.linspace(-3, 3, 50)
    e, phase = 5e-4, 0.7
    error = EncoderEccentricity(0, (e * np.cos(phase), e * np.sin(phase)))
    true, _, _ = error.corrected(q, 0 * q, 0 * q)
    assert true == pytest.approx(q + e * np.sin(q + phase), abs=1e-15)


@pytest.mark.parametrize(
    ("waves", "sizes"),
    [
        (1.0, (3e-4, -2e-4)),
        (2.0, (3e-4, -2e-4)),
        (3.0, (3e-4, -2e-4, 1e-4, 2e-4)),
        (6.0, (3e-4, -2e-4, 3e-5, 2e-5)),
    ],
)
@pytest.mark.parametrize("arm", [vertical_arm, panda])
def test_columns_give_the_exact_change_for_small_errors(arm, waves, sizes) -> None:
    robot = arm()
    motion = smooth_motion(robot, step=0.02)
    context = context_of(robot, motion)
    entry = CATALOGUE["encoder_eccentricity"]
    effect = entry.build(context, 1, (waves,))
    exact = entry.apply(context, 1, (waves,), np.array(sizes)).torque(context.parameters, motion)
    model = context.model.with_effects(effect)
    linear = model.torque(np.concatenate([context.parameters, sizes]), motion)
    before = context.model.torque(context.parameters, motion)
    assert np.abs(linear - exact).max() < 2e-3 * np.abs(exact - before).max()


def test_a_further_step_of_the_same_waves_adds_to_them():
    arm = vertical_arm()
    context = context_of(arm, smooth_motion(arm))
    entry = CATALOGUE["encoder_eccentricity"]
    for sizes in ((1e-3, 0.0), (2e-4, -3e-4)):
        model = entry.apply(context, 0, (1.0,), np.array(sizes))
        context = dataclasses.replace(context, model=model)
    (error,) = context.model.measurement
    assert error.waves == pytest.approx((1.2e-3, -3e-4))
    other = entry.apply(context, 1, (1.0,), np.array([1e-4, 0.0]))
    assert len(other.measurement) == 2
