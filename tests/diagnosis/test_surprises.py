"""The largest surprise of a search is that of its trials, scored one by one."""

import dataclasses

import numpy as np
import pytest
from scipy.stats import chi2

from oed.diagnosis.fit.addition import NormalEquations
from oed.diagnosis.search.scan import inflation_of, minus_log_chance, score
from oed.diagnosis.search.surrogates import largest_surprises
from oed.diagnosis.search.workbench import fit_layout
from tests.diagnosis.arm import data_set
from tests.diagnosis.shop import shop_of


def test_all_trials_at_once_are_each_by_itself():
    shop = shop_of(data_set(5))
    trials = [t for t in shop.physical if not t.between_repetitions]
    fit = shop.fit([], shop.layout(trials[0])).fit
    assert len(trials) > 64
    assert any(len(t.group) > 1 for t in trials)
    drawn = np.random.default_rng(0).normal(size=(*fit.residual.shape, 3))
    inflation = inflation_of(fit)
    expected = []
    for k in range(3):
        beside = fit.projection.residual(drawn[:, :, k])
        # As large as what was drawn, joint by joint.
        scale = np.linalg.norm(drawn[:, :, k], axis=1) / np.linalg.norm(beside, axis=1)
        left = dataclasses.replace(fit, residual=fit.projection.residual(beside * scale[:, None]))
        expected.append(max(score(t, left).surprise(inflation) for t in trials))
    assert largest_surprises(trials, fit, drawn) == pytest.approx(np.array(expected))


def test_a_search_finds_as_much_in_what_a_model_left_of_noise_as_in_other_noise():
    """Beside a model that takes half of it; other noise loses as much to the model once."""
    shop, rng = shop_of(data_set(5), held=False), np.random.default_rng(8)
    layout, size = shop.mean, shop.mean.torque.shape
    model = [rng.normal(size=(*size, size[1]))]
    fit = fit_layout(shop.baseline, layout, model, rng.normal(size=size))
    (some,) = (t for t in shop.physical if t.key == ("torque_offset", 0))
    columns = rng.normal(size=(20, size[1], 1))
    trials = [dataclasses.replace(some, group={0: own}) for own in columns]
    inflation, expected = inflation_of(fit), []
    for _ in range(60):
        other = dataclasses.replace(fit, residual=fit.projection.residual(rng.normal(size=size)))
        expected.append(max(score(t, other).surprise(inflation) for t in trials))
    signs = rng.choice([-1.0, 1.0], size=(1, size[1], 200))
    found = largest_surprises(trials, fit, fit.residual[:, :, None] * signs)
    # Largest surprises of twenty trials scatter by 1.1: their means by 0.16, of one fit by as much.
    assert np.mean(found) == pytest.approx(np.mean(expected), abs=0.6)


@pytest.mark.parametrize("freedom", [1, 2, 7, 60])
def test_chance_is_that_of_a_chi_square(freedom):
    gains = np.array([-1.0, 0.0, 1e-9, 0.3, 4.0, 50.0, 399.0])
    expected = -chi2.logsf(gains, freedom)
    assert minus_log_chance(gains, freedom) == pytest.approx(expected, rel=1e-12, abs=1e-15)


def test_one_column_is_solved_as_one_of_several():
    columns = np.random.default_rng(2).normal(size=(30, 2)) * [3.0, 0.0]
    y = np.arange(30.0)
    inside = np.zeros((0, 2))

    def solved(count: int):
        own = columns[:, :count]
        gram = own.T @ own
        return NormalEquations(gram, np.diag(gram), own.T @ y, inside[:, :count]).solved()

    alone, beside_nothing = solved(1), solved(2)
    assert alone.rank == beside_nothing.rank == 1
    assert alone.gain == pytest.approx(beside_nothing.gain)
    assert alone.coefficients[0] == pytest.approx(beside_nothing.coefficients[0])
