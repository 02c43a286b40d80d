"""Additions looked at again beside one another."""

import numpy as np
import pytest

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.search.exchange import settled
from tests.diagnosis.arm import VISCOUS, data_set
from tests.diagnosis.shop import shop_of, trial_of


def test_what_is_known_of_friction_is_that_beside_the_shapes_as_they_are():
    """Beside the derivatives of a bend in friction, viscous friction comes out half as large again."""

    def square(q, dq, ddq):
        return np.stack([3.0 * dq[:, 0] * np.abs(dq[:, 0]), np.zeros(len(q))], axis=1)

    dataset = data_set(3, extra=square, near=0.3, roles=("estimation", "validation"))
    shop = shop_of(dataset)
    bend = Accepted(trial_of(shop, "nonlinear_viscous", 0, (1.9, 0.0)), 600.0, 1e-6)
    settled(shop, [bend], [])
    assert shop.context.viscous(0) == pytest.approx(VISCOUS[0], rel=0.1)
