"""Crossing a gap: time and momentum in closed form, on stiff flanks."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.effects.transmission import Backlash, deflect
from tests.dynamics.effects.arms import context_of, scara, smooth_motion, vertical_arm

STEP = 1e-4
SLOPE = 10.0  # [N m/s] of the load through zero
INERTIA = 1.5  # [kg m^2]
HALF = 5e-4  # [rad]
RATE = 2 * np.pi * 100.0  # [rad/s] on a flank: far above the crossing
FLANK = (INERTIA * RATE**2, INERTIA * RATE, HALF)


def _crossing() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    t = np.arange(-0.2, 0.3, STEP)
    load = SLOPE * t
    d, _, ddd = deflect(t, load, np.full(len(t), INERTIA), FLANK)
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
    d, _, _ = deflect(t, 5 + np.sin(20 * t), np.full(len(t), INERTIA), FLANK)
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


def test_friction_behind_the_gear_keeps_the_links_on_a_flank() -> None:
    context = context_of(vertical_arm(), smooth_motion(vertical_arm(), step=1e-3))
    motion = smooth_motion(vertical_arm(), step=1e-3)
    build = CATALOGUE["backlash"].build
    free, braked = (
        evaluate(build(context, 1, (1e-3, 40.0, 0.5, 0.0, bearing)), motion, 2)[:, 1, 0]
        for bearing in (0.0, 1.0)
    )
    assert not np.allclose(free, braked, atol=0.1 * np.abs(free).max())


def test_refuses_a_gap_below_zero() -> None:
    good = Backlash(0, 30.0, 0.3, 0.2, 1e-3, 0.5, (0.0, 0.0), ReferenceTorque(scara()), 20)
    with pytest.raises(ValueError, match="gap"):
        dataclasses.replace(good, gap=-1e-3)
    with pytest.raises(ValueError, match="bearing"):
        dataclasses.replace(good, bearing=1.5)
