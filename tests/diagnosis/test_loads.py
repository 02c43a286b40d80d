"""Columns of a load that are filtered once are those that are filtered anew at every moment."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.terms.trials import white_group
from oed.diagnosis_new.rows.model_columns import effect_columns
from oed.dynamics.effects.payload import PayloadChange, PickUp
from tests.diagnosis.arm import PERIOD, data_set
from tests.diagnosis.shop import shop_of


def white_anew(effect, rows, *, contrast):
    """White columns by their definition: gate, take the mean off, filter, whiten."""
    result = {}
    for joint in (0, 1):
        blocks = []
        for p in rows.prepared:
            motion = p.mean_motion if contrast else p.motion
            fine = effect_columns(effect, motion, 0.0)[joint]
            blocks.append(fine - p.phase_mean(fine) if contrast else fine)
        result[joint] = rows.whiten_fine(blocks, joint)
    return result


@pytest.fixture(scope="module")
def shop():
    return shop_of(data_set(0))


@pytest.mark.parametrize("contrast", [False, True])
@pytest.mark.parametrize("moment", [-1.0, 0.4, 1.1 * PERIOD, 7.77, 1e9])
@pytest.mark.parametrize("own", [None, 2.5, np.inf])
def test_the_columns_at_any_moment(moment, own, contrast, shop):
    rows, robot = shop.full.rows, shop.context.model.robot
    t = rows.prepared[-1].motion.t
    pickups = () if own is None else (PickUp(t[0], t[-1], t[0] + own),)
    effect = PayloadChange(robot, 1, moment, (0, 1, 9), pickups=pickups)
    for changed in (effect, dataclasses.replace(effect, moment=moment + 0.013)):
        found = white_group(changed, rows, contrast=contrast)
        expected = white_anew(changed, rows, contrast=contrast)
        size = max(np.abs(expected[joint]).max() for joint in expected)
        for joint, block in expected.items():
            np.testing.assert_allclose(found[joint], block, rtol=0, atol=1e-12 * max(size, 1.0))


def test_other_loads_do_not_share_their_columns(shop):
    rows, robot = shop.full.rows, shop.context.model.robot
    one, other = (white_group(PayloadChange(robot, 1, 3.0, kept), rows) for kept in ((0,), (9,)))
    assert not np.allclose(one[1], other[1])
