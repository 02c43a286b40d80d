"""Crossing a gap: time and momentum in closed form."""

import numpy as np
import pytest

from oed.dynamics.effects.backlash import Backlash, cross_gap
from oed.dynamics.effects.entry import evaluate
from tests.dynamics.effects.arms import context_of, scara, smooth_motion, vertical_arm

STEP = 1e-4
SLOPE = 10.0  # [N m/s] of the load through zero
INERTIA = 1.5  # [kg m^2]
HALF = 5e-4  # [rad]


def _crossing() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    t = np.arange(-0.2, 0.3, STEP)
    load = SLOPE * t
    flank, lost = cross_gap(t, load, np.full(len(t), INERTIA), HALF)
    return t, load, flank, lost


def test_crossing_takes_the_time_of_free_flight() -> None:
    t, _, flank, _ = _crossing()
    flight = (12 * HALF * INERTIA / SLOPE) ** (1 / 3)  # 2b = slope T^3 / (6 M)
    landed = t[np.flatnonzero(flank >= 1.0)[0]]
    assert landed == pytest.approx(flight, abs=5 * STEP)


def test_nothing_is_transmitted_in_the_gap() -> None:
    _, load, flank, lost = _crossing()
    inside = np.abs(flank) < 1
    assert inside.sum() > 100
    assert (load + lost)[inside] == pytest.approx(0.0, abs=1e-12)


def test_the_far_flank_gives_back_the_lost_momentum() -> None:
    _, load, _, lost = _crossing()
    assert abs(lost.sum() * STEP) < 0.02 * np.abs(np.minimum(lost, 0)).sum() * STEP
    assert lost.max() > load.max()


def test_load_of_one_sign_stays_on_its_flank() -> None:
    t = np.arange(0, 1, 1e-3)
    flank, lost = cross_gap(t, 5 + np.sin(20 * t), np.ones(len(t)), HALF)
    assert (flank == 1).all()
    assert not lost.any()


def test_flank_follows_the_load_and_not_the_motion() -> None:
    arm = vertical_arm()
    motion = smooth_motion(arm)
    context = context_of(arm, motion)
    flank = evaluate(Backlash(0, 1e-4, context.reference), motion, 2)[:, 0, 0]
    load = context.reference.parts(motion)[:, 0, 0]
    far_from_zero = np.abs(load) > 0.2 * np.abs(load).max()
    assert np.array_equal(flank[far_from_zero], np.sign(load[far_from_zero]))


def test_refuses_a_gap_of_zero() -> None:
    with pytest.raises(ValueError, match="gap"):
        Backlash(0, 0.0, context_of(scara()).reference)
