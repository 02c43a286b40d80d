"""Drag between two joints is a coupled motor's only if something of a motor comes with it."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.evidence.motorless import motorless
from oed.diagnosis.evidence.uncertainty import with_uncertainty
from tests.diagnosis.arm import data_set
from tests.diagnosis.shop import shop_of, trial_of

RATIO = 0.8
DRAG = 0.9  # [N m s/rad]


def coupled(inertia, coulomb):
    """Torque of something that turns with the first joint and a share of the second."""

    def torque(q, dq, ddq):
        speed, rate = (x[:, 0] + RATIO * x[:, 1] for x in (dq, ddq))
        own = DRAG * speed + coulomb * np.sign(speed) + inertia * rate
        return np.stack([own, RATIO * own], axis=1)

    return torque


@pytest.mark.parametrize(
    ("inertia", "coulomb", "is_none"), [(0.0, 0.0, True), (0.05, 0.0, False), (0.0, 0.4, False)]
)
def test_drag_alone_is_no_motor(inertia, coulomb, is_none):
    shop = shop_of(data_set(6, extra=coupled(inertia, coulomb), roles=("estimation",) * 2))
    trial = trial_of(shop, "motor_coupling", (1, 0), (RATIO, 2.0))
    found = with_uncertainty(shop, shop.fit([trial], shop.mean, bend=False))
    assert (motorless(found) is trial) is is_none


def test_other_names_are_not_asked_for_a_motor():
    shop = shop_of(data_set(6, roles=("estimation",)))
    trial = trial_of(shop, "torque_offset", 0)
    found = with_uncertainty(shop, shop.fit([trial], shop.mean, bend=False))
    assert motorless(dataclasses.replace(found, coefficients=(np.zeros(1),))) is None
