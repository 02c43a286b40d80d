"""Crossing a gap: in closed form on stiff flanks, and against a two-mass arm's full equations."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.context import Context
from oed.dynamics.effects.deflection import deflect
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.effects.transmission import Backlash
from oed.dynamics.torque_model import TorqueModel
from tests.dynamics.effects.arms import (
    context_of,
    parameters_of,
    scara,
    smooth_motion,
    vertical_arm,
)
from tests.dynamics.effects.two_mass import Gear, two_mass_torque

STEP = 1e-4
SLOPE = 10.0  # [N m/s] of the load through zero
INERTIA = 1.5  # [kg m^2]
HALF = 5e-4  # [rad]
RATE = 2 * np.pi * 100.0  # [rad/s] on a flank: far above the crossing
FLANK = (INERTIA * RATE**2, INERTIA * RATE, HALF, 0.0)
SMOOTH = (0.0, 1.0, 0.0)  # a bearing without friction


def _crossing() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    t = np.arange(-0.2, 0.3, STEP)
    load = SLOPE * t
    d, _, ddd = deflect(t, load, np.full(len(t), INERTIA), FLANK, (np.zeros(len(t)), *SMOOTH))
    return t, load, d, load - INERTIA * ddd


def test_crossing_takes_the_time_of_free_flight() -> None:
    t, _, d, _ = _crossing()
    flight = (12 * HALF * INERTIA / SLOPE) ** (1 / 3)  # 2b = slope T^3 / (6 M)
    landed = t[np.flatnonzero(d >= HALF)[0]]
    # The near flank, pressed until then, lets go some periods of its spring late.
    assert landed == pytest.approx(flight, abs=3 / RATE)


def test_nothing_is_transmitted_in_the_gap() -> None:
    _, load, d, push = _crossing()
    inside = np.abs(d) < 0.99 * HALF
    assert inside.sum() > 100
    assert push[inside] == pytest.approx(0.0, abs=1e-9 * np.abs(load).max())


def test_the_far_flank_gives_back_the_lost_momentum() -> None:
    t, load, _, push = _crossing()
    lost = push - load
    assert abs(lost[t > -0.1].sum()) < 0.02 * np.abs(np.minimum(lost, 0)).sum()
    assert lost.max() > load.max()


def test_load_of_one_sign_stays_on_its_flank() -> None:
    t = np.arange(0, 1, 1e-3)
    load, inertia, still = 5 + np.sin(20 * t), np.full(len(t), INERTIA), np.zeros(len(t))
    d, _, _ = deflect(t, load, inertia, FLANK, (still, *SMOOTH))
    assert (d >= HALF).all()


def test_what_is_felt_changes_where_the_load_changes_sides() -> None:
    arm = scara()
    motion = smooth_motion(arm, step=1e-3)
    context = context_of(arm, motion)
    effect = CATALOGUE["backlash"].build(context, 0, (5e-4, 60.0, 0.5, 0.0, 0.0))
    change = evaluate(effect, motion, 2)
    load = context.reference.parts(motion)[:, 0, 0]
    flips = motion.t[1:][np.diff(np.sign(load)) != 0]
    after = np.abs(motion.t[:, None] - flips).min(axis=1) < 0.3
    assert 0 < after.mean() < 0.7
    # The other joint feels it too, and neither feels much of it elsewhere.
    assert (np.abs(change[after, :, 0]).max(axis=0) > 0.02).all()
    energy = np.sum(change[:, :, 0] ** 2, axis=0)
    assert (np.sum(change[after, :, 0] ** 2, axis=0) > 0.9 * energy).all()


def test_links_that_stick_stay_while_the_motor_crosses_the_gap() -> None:
    t = np.arange(0.0, 0.4, STEP)
    speed = np.where(t < 0.1, -0.004, 0.004)  # [rad/s]
    # Friction of 2 N m holds the links against a load of 1 N m.
    load, inertia = np.full(len(t), -1.0), np.full(len(t), INERTIA)
    d, v, _ = deflect(t, load, inertia, FLANK, (speed, 2.0, 1e-6, 0.0))
    inside = np.abs(d) < 0.99 * HALF
    assert t[inside].max() - t[inside].min() == pytest.approx(2 * HALF / 0.004, rel=0.02)
    # What speed they had when the flank let go is braked away in a few steps.
    assert v[inside][50:] == pytest.approx(speed[inside][50:], rel=1e-3)


@pytest.mark.parametrize("joint", [0, 1])
def test_every_joint_feels_the_gap_of_a_braked_arm(joint: int) -> None:
    robot, hertz, damping, rotor, bearing = vertical_arm(), 20.0, 0.6, 0.3, 0.6
    motion = smooth_motion(robot, duration=3.0, step=1e-3)
    model = TorqueModel.standard(robot, sign_width=0.01)
    parameters = parameters_of(model)
    context = Context.of(model, parameters, [motion])
    friction = model.torque(parameters, motion) - model.torque(
        np.concatenate([robot.parameters, np.zeros(4)]), motion
    )
    gear = Gear(hertz, damping, rotor, 2e-3, 2.0 * bearing, 0.01, 1.0 * bearing)
    true = two_mass_torque(robot, motion, joint, gear) + friction
    true[:, joint] -= bearing * friction[:, joint]
    entry, values = CATALOGUE["backlash"], (2e-3, hertz, damping, rotor, bearing)
    seen = entry.apply(context, joint, values, np.ones(1)).torque(parameters, motion)
    rigid = model.torque(parameters, motion)
    # A blow's edge falls between two samples: what counts is its momentum.
    mean = np.ones(20) / 20
    error, change = (
        np.stack([np.convolve(x, mean)[200:] for x in (seen - other).T], axis=1)
        for other in (true, rigid)
    )
    # Of second order in a bend of some mrad.
    assert (np.linalg.norm(error, axis=0) < 0.01 * np.linalg.norm(change, axis=0)).all()


def test_friction_behind_the_gear_keeps_the_links_on_a_flank() -> None:
    context = context_of(vertical_arm(), smooth_motion(vertical_arm(), step=1e-3))
    motion = smooth_motion(vertical_arm(), step=1e-3)
    build = CATALOGUE["backlash"].build
    free, braked = (
        evaluate(build(context, 1, (1e-3, 40.0, 0.5, 0.0, bearing)), motion, 2)[:, 1, 0]
        for bearing in (0.0, 1.0)
    )
    assert not np.allclose(free, braked, atol=0.1 * np.abs(free).max())


def test_a_gap_that_drowns_in_the_bend_is_not_plausible() -> None:
    context, entry = context_of(vertical_arm()), CATALOGUE["backlash"]
    stiff, soft = (5e-4, 40.0, 0.5, 0.3, 0.5), (5e-4, 5.0, 0.5, 0.3, 0.5)
    assert entry.plausible(context, 1, stiff, np.ones(1)) is None
    reason = entry.plausible(context, 1, soft, np.ones(1))
    assert reason is not None
    assert "gap" in reason


def test_refuses_a_gap_below_zero() -> None:
    good = Backlash(0, 30.0, 0.3, 0.2, 1e-3, 0.5, (0.0, 0.0), ReferenceTorque(scara()))
    with pytest.raises(ValueError, match="gap"):
        dataclasses.replace(good, gap=-1e-3)
    with pytest.raises(ValueError, match="bearing"):
        dataclasses.replace(good, bearing=1.5)
