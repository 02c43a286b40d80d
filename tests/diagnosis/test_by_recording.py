"""The deviation of a shape from what recordings want, held against what estimates scatter by."""

import numpy as np
from scipy.stats import norm, t

from oed.diagnosis.evidence.by_recording import rugged_shapes, spread_by_recording
from oed.dynamics.effects.catalogue import CATALOGUE
from tests.diagnosis.arm import data_set, stribeck
from tests.diagnosis.shop import shop_of, trial_of

SPEED = 0.1  # [rad/s] at which friction has fallen
RECORDINGS = 3  # two for estimation, one for validation
SEEDS = range(8)


def at_speed(shop, speed):
    return trial_of(shop, "stribeck", 0, (speed, 2.0, 1.0))


def best_axis(shop, shape):
    """Where estimation and validation recordings together want it, from a search of its own."""
    axes = shape.place_of(SPEED) + np.linspace(-0.15, 0.15, 61)
    left = []
    for axis in axes:
        found = shop.fit([at_speed(shop, shape.at(float(axis)))], bend=False)
        left.append(found.fit.squares + np.sum(shop.unseen.left(found)))
    return float(axes[np.argmin(left)])


def test_recordings_differ_by_what_estimates_of_them_all_scatter_by():
    errors, stated = [], []
    for seed in SEEDS:
        shop = shop_of(data_set(seed, extra=stribeck(0.5, SPEED)))
        shape = CATALOGUE["stribeck"].shapes_for(shop.context, 0)[0]
        best = best_axis(shop, shape)
        found = shop.fit([at_speed(shop, shape.at(best))])
        errors.append(best - shape.place_of(SPEED))
        stated.append(spread_by_recording(shop, found, 0, 0))
    student = t.ppf(0.975, RECORDINGS - 1) / norm.ppf(0.975)
    ratio = np.sqrt(np.mean(np.square(stated)) / np.mean(np.square(errors))) / student
    # A root mean square of 8 errors over one of 8 spreads of three: 95 % lie within a factor of two.
    assert 0.5 < ratio < 2


def test_one_recording_tells_no_spread():
    shop = shop_of(data_set(0, extra=stribeck(0.5, SPEED), roles=("estimation",)), held=False)
    found = shop.fit([at_speed(shop, SPEED)])
    assert spread_by_recording(shop, found, 0, 0) == 0.0


def test_a_gap_alone_has_crests():
    shop = shop_of(data_set(0))
    assert rugged_shapes(trial_of(shop, "backlash", 1), shop.context) == [0]
    assert rugged_shapes(trial_of(shop, "joint_elasticity", 1), shop.context) == []
    assert rugged_shapes(trial_of(shop, "torque_offset", 1), shop.context) == []
