"""Additions looked at again beside one another."""

import dataclasses

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.search.exchange import settled
from oed.diagnosis.tables.workbench import comes_first, early_and_late
from tests.diagnosis.arm import RATE, VISCOUS, data_set
from tests.diagnosis.shop import shop_of, trial_of


def test_what_is_known_of_friction_is_that_beside_the_shapes_as_they_are():
    """Beside the derivatives of a bend in friction, viscous friction comes out half as large again."""

    def square(q, dq, ddq):
        return np.stack([3.0 * dq[:, 0] * np.abs(dq[:, 0]), np.zeros(len(q))], axis=1)

    dataset = data_set(3, extra=square, near=0.3, roles=("estimation", "validation"))
    shop = shop_of(dataset)
    bend = Accepted(trial_of(shop, "nonlinear_viscous", 0, (1.9, 0.0)), 600.0)
    settled(shop, [bend], [])
    assert shop.context.viscous(0) == pytest.approx(VISCOUS[0], rel=0.1)


def test_no_torque_that_comes_first_takes_a_place_beside_one_that_is_late():
    """A torque that is smoothed forward and backward is both at once, which no log is."""
    logged = data_set(3, roles=("estimation", "validation"))
    smooth = tuple(
        dataclasses.replace(r, tau=gaussian_filter1d(r.tau, 0.02 * RATE, axis=0))
        for r in logged.recordings
    )
    shop = shop_of(dataclasses.replace(logged, recordings=smooth))
    idle = Accepted(trial_of(shop, "torque_offset", 0), 600.0)
    lag = Accepted(trial_of(shop, "filter_lag", None, (0.02,)), 600.0)
    pool = [t for t in shop.physical if t.name == "time_delay"]
    assert any(map(comes_first, pool))
    kept = settled(shop, [idle, lag], pool)
    assert not early_and_late([a.trial for a in kept])
