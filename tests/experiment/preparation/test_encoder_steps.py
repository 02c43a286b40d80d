"""Steps of an encoder, and what their rounding does to the torque, against rounded signals."""

import dataclasses
from functools import partial

import numpy as np
import pytest

from oed.dynamics.effects import RigidBody
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.encoder_steps import (
    encoder_steps,
    fine_encoder_torque,
    repeated_steps,
)
from oed.experiment.preparation.mean_repetition import mean_of_repetitions
from oed.experiment.preparation.prepare import prepare
from oed.experiment.recording import Recording
from oed.robot.builtin import imi_scara

RATE, PERIOD, REPETITIONS = 1000.0, 6.0, 5
STEP = 3e-5  # [rad]


def recording(*, step=STEP, digits=None, apart=0.0, repetitions=REPETITIONS, speed=1.0):
    """A repeated motion, each repetition shifted at random by `apart` steps."""
    rng = np.random.default_rng(7)
    t = np.arange(round(repetitions * PERIOD * RATE)) / RATE
    turn = (t // PERIOD).astype(int)
    angle = 2 * np.pi * t / PERIOD
    q = np.stack(
        [
            0.6 * np.sin(angle) + 0.3 * np.cos(3 * angle),
            speed * (np.cos(2 * angle) - np.sin(angle)),
        ],
        axis=1,
    )
    exact = q + apart * STEP * rng.normal(size=(repetitions, 2))[turn]
    q = np.round(exact / step) * step if step else exact
    q = q if digits is None else np.round(q, digits)
    tau = np.sin(angle)[:, None] + 0.1 * rng.normal(size=q.shape)  # of a sensor, not of a filter
    repeated = {"repetition": turn, "period": PERIOD} if repetitions > 1 else {}
    return exact, Recording("a", "estimation", t, q, tau, **repeated)


@pytest.mark.parametrize("speed", [0.02, 1.0, 4.0])
@pytest.mark.parametrize(("step", "digits"), [(STEP, None), (STEP, 5), (3.835e-4, 7)])
def test_finds_the_step_of_slow_and_of_fast_joints(step, digits, speed):
    _, own = recording(step=step, digits=digits, speed=speed)
    assert encoder_steps([own]) == pytest.approx([step, step], rel=1e-3)


def test_what_is_not_rounded_has_no_step_that_matters():
    _, own = recording(step=0)
    assert np.all(encoder_steps([own]) < 1e-7)


def test_rounding_repeats_as_far_as_the_motion_does():
    assert repeated_steps([recording()[1]]) == pytest.approx([STEP, STEP])
    assert repeated_steps([recording(apart=3.0)[1]]) == pytest.approx([0.0, 0.0])
    assert repeated_steps([recording(repetitions=1)[1]]) == pytest.approx([0.0, 0.0])
    # Rounding errors of two repetitions correlate as their shift has it.
    exact, own = recording(apart=0.04)
    error = (own.q - exact).reshape(REPETITIONS, -1, 2)
    together = np.mean([error[k] * error[k + 1] for k in range(REPETITIONS - 1)], axis=(0, 1))
    share = (repeated_steps([own]) / STEP) ** 2
    assert share == pytest.approx(together / np.mean(error**2, axis=(0, 1)), abs=0.08)


def test_torque_errs_as_much_as_rounded_positions_make_it():
    exact, own = recording()
    robot = imi_scara()
    model = TorqueModel(robot, (RigidBody(robot),))
    sharp = dataclasses.replace(own, name="b", q=exact)
    # One call: both go through the same band.
    rounded, clean = prepare((own, sharp))
    parameters = robot.parameters
    band = rounded.band
    real = band.apply(
        model.torque(parameters, rounded.motion) - model.torque(parameters, clean.motion)
    )
    (errors,) = fine_encoder_torque(partial(model.torque, parameters), [rounded])
    stated = band.apply(errors)
    assert stated.std(axis=0) == pytest.approx(real.std(axis=0), rel=0.15)


def test_a_joint_that_rests_says_nothing_of_how_its_rounding_repeats():
    """Half of each repetition at rest, where all samples agree; moving they lie steps apart."""
    _, own = recording(apart=3.0)
    still = (own.t % PERIOD) > PERIOD / 2
    resting = dataclasses.replace(own, q=np.where(still[:, None], 0.0, own.q))
    assert repeated_steps([resting]) == pytest.approx([0.0, 0.0], abs=0.05 * STEP)


def test_rounding_errs_nothing_new_where_a_joint_rests():
    _, own = recording()
    still = (own.t % PERIOD) > PERIOD / 2
    resting = dataclasses.replace(own, q=np.where(still[:, None], own.q[0], own.q))
    robot = imi_scara()
    model = TorqueModel(robot, (RigidBody(robot),))
    (prepared,) = prepare((resting,))
    (fine,) = fine_encoder_torque(partial(model.torque, robot.parameters), [prepared])
    errors = prepared.band.apply(fine)
    phase = prepared.t % PERIOD
    resting, moving = phase > 0.6 * PERIOD, (phase > 0.1 * PERIOD) & (phase < 0.4 * PERIOD)
    resting &= phase < 0.9 * PERIOD
    assert np.all(errors[resting].std(axis=0) < 0.02 * errors[moving].std(axis=0))


@pytest.mark.parametrize(("apart", "share"), [(0.0, 1.0), (3.0, 1 / np.sqrt(REPETITIONS))])
def test_a_mean_keeps_the_rounding_that_every_repetition_has(apart, share):
    _, own = recording(apart=apart)
    (prepared,) = prepare((own,))
    mean, count = mean_of_repetitions(prepared)
    assert count == REPETITIONS
    assert prepared.position_noise == pytest.approx([STEP / np.sqrt(12)] * 2, rel=0.1)
    assert mean.position_noise == pytest.approx(share * prepared.position_noise, rel=0.05)
