"""Mirror ascent against Newton's method and against what is known in closed form."""

import numpy as np
import pytest

from oed.design.bound.balanced_ascent import ascend, gradient, project
from oed.design.bound.weights import optimal_weights


def test_reaches_what_newtons_method_finds() -> None:
    rng = np.random.default_rng(1)
    rows, balance = rng.standard_normal((300, 2, 5)), rng.standard_normal((300, 3))
    best = np.linalg.slogdet(optimal_weights(rows, balance).information)[1]
    point = ascend(rows, balance, np.full(300, 1 / 300), steps=400)
    assert np.linalg.slogdet(point.information)[1] == pytest.approx(best, abs=2e-3)


def test_its_multipliers_make_the_dual_almost_feasible() -> None:
    rng = np.random.default_rng(4)
    rows, balance = rng.standard_normal((300, 2, 5)), rng.standard_normal((300, 3)) * [1, 100, 0.01]
    point = ascend(rows, balance, np.full(300, 1 / 300), steps=400)
    dual = gradient(rows, point.information) - balance @ point.multipliers
    assert 5.0 - 1e-6 <= dual.max() < 5.0 * 1.02


def test_weights_stay_balanced_positive_and_of_unit_sum() -> None:
    rng = np.random.default_rng(5)
    rows, balance = rng.standard_normal((200, 1, 4)), rng.standard_normal((200, 6))
    point = ascend(rows, balance, rng.random(200) + 0.01, steps=20)
    assert point.imbalance < 1e-8
    assert (point.weights > 0).all()
    assert point.weights.sum() == pytest.approx(1.0)


def test_projection_of_two_atoms_is_known() -> None:
    # w_1 = w_2 is the only balance of rates 1 and -1; the tilt is half the log of their ratio.
    weights, y = project(np.array([0.8, 0.2]), np.array([[1.0], [-1.0]]))
    np.testing.assert_allclose(weights, 0.5)
    assert y[0] == pytest.approx(np.log(4) / 2)


def test_equalities_that_repeat_each_other_do_no_harm() -> None:
    rng = np.random.default_rng(6)
    once = rng.standard_normal((100, 2))
    weights, _ = project(np.full(100, 0.01), np.concatenate([once, once], axis=1))
    np.testing.assert_allclose(weights @ once, 0.0, atol=1e-8)
