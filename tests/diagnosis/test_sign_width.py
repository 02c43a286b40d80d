"""How sharply friction turns, read off recordings whose friction is known."""

import numpy as np
import pytest

from oed.diagnosis.search.selection import search
from oed.diagnosis_new.noise.sign_width import LARGEST_WIDTH
from oed.dynamics.effects import Coulomb, State
from tests.diagnosis.arm import COULOMB, data_set
from tests.diagnosis.shop import shop_of


def at_once(speed, width):
    return np.tanh(speed / width)


def by_and_by(speed, width):
    return speed / np.hypot(speed, width)


def turning_over(width, turn=at_once):
    """What dry friction that rises with the velocity differs by from one that switches."""

    def torque(q, dq, ddq):
        return COULOMB * (turn(dq, width) - np.sign(dq)) * [1.0, 0.0]

    return torque


@pytest.mark.parametrize("turn", [at_once, by_and_by])
@pytest.mark.parametrize("share", [0.06, 0.12])
def test_a_sign_turns_as_slowly_as_the_friction_does(share, turn):
    """Up to some share of the usual speed it is no effect of its own, whatever its shape."""
    bare = shop_of(data_set(2))
    speed = float(
        np.sqrt(np.mean(np.concatenate([p.motion.dq[:, 0] for p in bare.estimation]) ** 2))
    )
    shop = shop_of(data_set(2, extra=turning_over(share * speed, turn)))
    first = next(e for e in shop.before.fit.model.effects if isinstance(e, Coulomb))
    assert first.width == pytest.approx(share * speed, rel=0.1)
    assert first.gradual is (turn is by_and_by)
    assert share < LARGEST_WIDTH
    names = ("nonlinear_viscous", "stribeck", "presliding_hysteresis")
    extra = turning_over(share * speed, turn)
    _, found = search(shop_of(data_set(2, extra=extra), candidates=names))
    assert found.trials == ()


def test_a_gradual_sign_is_what_it_says():
    speed = np.linspace(-2, 2, 9)
    state = State(t=0.0, q=(0 * speed,), dq=(speed,), ddq=(0 * speed,))
    (entry,) = Coulomb(0, 0.3, gradual=True).entries(state)
    np.testing.assert_allclose(entry[0], by_and_by(speed, 0.3), rtol=1e-14)
    (exact,) = Coulomb(0, 0.0, gradual=True).entries(state)
    np.testing.assert_array_equal(exact[0], np.sign(speed))
