"""How sharply friction turns, read off recordings whose friction is known."""

import numpy as np

from oed.dynamics.effects import Coulomb, State


def by_and_by(speed, width):
    return speed / np.hypot(speed, width)


def test_a_gradual_sign_is_what_it_says():
    speed = np.linspace(-2, 2, 9)
    state = State(t=0.0, q=(0 * speed,), dq=(speed,), ddq=(0 * speed,))
    (entry,) = Coulomb(0, 0.3, gradual=True).entries(state)
    np.testing.assert_allclose(entry[0], by_and_by(speed, 0.3), rtol=1e-14)
    (exact,) = Coulomb(0, 0.0, gradual=True).entries(state)
    np.testing.assert_array_equal(exact[0], np.sign(speed))
