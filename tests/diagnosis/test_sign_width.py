"""How sharply friction turns, read off recordings whose friction is known."""

import numpy as np
import pytest

from oed.diagnosis.baseline.sign_width import LARGEST_WIDTH, widths_of
from oed.diagnosis.search.selection import search
from tests.diagnosis.arm import COULOMB, data_set
from tests.diagnosis.shop import shop_of


def turning_over(width):
    """What dry friction that rises with the velocity differs by from one that switches."""

    def torque(q, dq, ddq):
        return COULOMB * (np.tanh(dq / width) - np.sign(dq)) * [1.0, 0.0]

    return torque


@pytest.mark.parametrize("share", [0.06, 0.12])
def test_a_sign_turns_as_slowly_as_the_friction_does(share):
    """Up to some share of the usual speed it is no effect of its own."""
    bare = shop_of(data_set(2))
    speed = float(
        np.sqrt(np.mean(np.concatenate([p.motion.dq[:, 0] for p in bare.estimation]) ** 2))
    )
    shop = shop_of(data_set(2, extra=turning_over(share * speed)))
    first, _ = widths_of(shop.before.fit.model)
    assert first == pytest.approx(share * speed, rel=0.1)
    assert share < LARGEST_WIDTH
    names = ("nonlinear_viscous", "stribeck", "presliding_hysteresis")
    _, found = search(shop_of(data_set(2, extra=turning_over(share * speed)), candidates=names))
    assert found.trials == ()
