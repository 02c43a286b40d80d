"""The largest surprise of a search is that of its trials, scored one by one."""

import dataclasses

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import chi2

from oed.diagnosis.candidates.surrogates import NullSearch, flipped, moved_in_time, undiminished
from oed.diagnosis.tables.workbench import fit_layout
from oed.diagnosis.terms.scores import inflation_of, minus_log_chance, score, scores
from oed.diagnosis.terms.trials import dense
from oed.diagnosis_new.noise.addition import NormalEquations
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
        left = dataclasses.replace(fit, residual=fit.projection.residual(drawn[:, :, k]))
        expected.append(max(score(t, left).surprise(inflation) for t in trials))
    found = NullSearch.beside(fit, trials).largest_surprises(drawn)
    assert found == pytest.approx(np.array(expected))


def white(rng, size):
    return rng.normal(size=size)


def slow(rng, size):
    """Of unit variance, correlated over five rows."""
    pole = 0.8
    drawn = rng.normal(size=(size[0], size[1] + 100))
    return np.asarray(lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], drawn))[:, 100:]


def waves(rng, rows, count):
    """Columns that change as slowly as the slowest sixteenth of all that rows can show."""
    share = rng.uniform(0, 1 / 32, size=count)
    return np.cos(2 * np.pi * share * np.arange(rows)[:, None] + rng.uniform(0, 6, size=count))


@pytest.mark.parametrize(
    ("noise", "moved"), [(white, flipped), (white, moved_in_time), (slow, moved_in_time)]
)
def test_a_search_finds_as_much_in_what_a_model_left_of_noise_as_in_other_noise(noise, moved):
    """Beside a model as slow as what is sought, which takes most of the noise there is so slow."""
    shop, rng = shop_of(data_set(5), held=False), np.random.default_rng(8)
    layout, size = shop.mean, shop.mean.torque.shape
    # Half of what is as slow as the trials: they have only the rest of it to themselves.
    model = np.zeros((*size, size[1] // 16))
    for joint, block in enumerate(np.array_split(model, size[0], axis=2)):
        block[joint] = waves(rng, size[1], block.shape[2])
    (some,) = (t for t in shop.physical if t.key == ("torque_offset", 0))
    columns = waves(rng, size[1], 20)[:, :, None]
    trials = [dataclasses.replace(some, group={0: columns[:, k]}) for k in range(20)]
    expected, found = [], []
    for _ in range(12):
        fit = fit_layout(shop.baseline, layout, layout.span.extended(model), noise(rng, size))
        inflation = inflation_of(fit)
        expected += [max(score(t, fit).surprise(inflation) for t in trials)]
        drawn = moved(undiminished(fit), fit.rows, 40, rng)
        found.append(NullSearch.beside(fit, trials).largest_surprises(drawn).mean())
    spread = np.std(expected) / np.sqrt(len(expected))
    assert np.mean(found) == pytest.approx(np.mean(expected), abs=3 * spread)


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


def test_each_of_many_gains_what_a_least_squares_fit_with_it_leaves_less():
    shop = shop_of(data_set(5))
    layout = shop.mean
    trials = [t for t in shop.physical if not t.between_repetitions]
    chosen = {t.key: t for t in trials}.values()  # the last shape of each
    fit = shop.fit([], layout).fit
    flat = np.concatenate([layout.regressor, layout.nuisances], axis=2).reshape(
        fit.residual.size, -1
    )
    flat = flat / np.where(norms := np.linalg.norm(flat, axis=0), norms, 1.0)

    def left(columns, target):
        return target - columns @ np.linalg.lstsq(columns, target, rcond=1e-7)[0]

    before = np.sum(left(flat, layout.torque.ravel()) ** 2)
    kinds = set()
    for own in scores(list(chosen), fit):
        whole = dense(own.trial, *fit.residual.shape).reshape(len(flat), -1)
        if own.freedom < whole.shape[1] and not own.trial.fixed:
            continue  # part of it is the model's, up to a tolerance that is not this fit's
        target, columns = layout.torque.ravel(), np.hstack([flat, whole])
        if own.trial.fixed:
            target, columns = target - whole.sum(axis=1), flat
        expected = before - np.sum(left(columns, target) ** 2)
        assert own.gain == pytest.approx(expected, rel=1e-5, abs=1e-6 * before), own.trial.key
        kinds.add((own.trial.fixed, whole.shape[1] > 1))
    assert kinds == {(True, False), (False, False), (False, True)}
