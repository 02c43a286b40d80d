"""What a lag makes of the rounding of encoders, against signals that were rounded and were not."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.candidates.calming import worth_beside
from oed.diagnosis.candidates.margin import decisive_between
from oed.diagnosis.fit.motion_noise import calmed
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.tables.workbench import lags_of
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import refine
from oed.diagnosis.terms.scores import gain_of, score
from oed.diagnosis.terms.trials import moved
from oed.diagnosis_new.noise.baseline import find_baseline
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import data_set
from tests.diagnosis.shop import shop_of, trial_of

STEP = 1e-3  # [rad]
LATE = 0.01  # [s]
ROLES = ("estimation", *["validation"] * 5)


@pytest.fixture(scope="module")
def laid_out():
    """A workshop of rounded recordings, and its validation recordings without rounding."""
    rounded, exact = (
        data_set(3, step=s, repetitions=1, roles=ROLES, shake=20.0) for s in (STEP, 0.0)
    )
    sharp = [dataclasses.replace(r, name=f"exact {r.name}") for r in exact.validation]
    settings = DiagnosisSettings()
    # One call: all go through the same band.
    estimation, *others = prepare((*rounded.recordings, *sharp))
    validation, truth = tuple(others[: len(sharp)]), tuple(others[len(sharp) :])
    baseline = find_baseline(TorqueModel.standard(rounded.robot), (estimation,))
    return Workshop(baseline, (estimation,), validation, settings), truth


def lag_of(shop):
    lags = [t for t in shop.physical if t.name == "filter_lag"]
    return min(lags, key=lambda t: abs(t.values[0] - LATE))


def delay_of(shop):
    """The delay of the grid that is nearest to what the torque has."""
    delays = [t for t in shop.physical if t.name == "time_delay"]
    return min(delays, key=lambda t: abs(t.values[0] - LATE))


def heard(rows, errors):
    """(n,) white squares of what is known to be an error."""
    return np.array([np.sum(rows.whiten([e[:, [j]] for e in errors], j) ** 2) for j in range(2)])


def test_a_lag_quietens_a_motion_run_once_by_what_its_rounding_errs(laid_out):
    shop, truth = laid_out
    lag = lag_of(shop)
    rows = shop.unseen_by([lag]).rows
    parameters = shop.before.fit.full_parameters()
    squares = []
    for model in (shop.baseline.model, shop.baseline.model.with_measurement(*lags_of([lag]))):
        errors = [
            p.band.apply(model.torque(parameters, p.motion) - model.torque(parameters, q.motion))
            for p, q in zip(rows.prepared, truth, strict=True)
        ]
        squares.append(heard(rows, errors))
    real = squares[0] - squares[1]
    assert np.all(real > 0)
    # One draw of rounding errors against another: the ratio scatters by 0.12 from seed to seed.
    assert calmed(lag.effect, rows).sum() == pytest.approx(real.sum(), rel=0.3)


def test_a_delay_quietens_next_to_nothing_and_other_effects_nothing(laid_out):
    shop, _ = laid_out
    rows = shop.unseen_by([]).rows
    delay = delay_of(shop)
    assert np.all(np.abs(calmed(delay.effect, rows)) < 0.1 * calmed(lag_of(shop).effect, rows))
    offset = next(t for t in shop.physical if t.name == "torque_offset")
    assert calmed(offset.effect, rows) == pytest.approx(0.0)


def test_what_noise_alone_may_make_of_the_difference_decides_nothing(laid_out):
    shop, _ = laid_out
    delay = delay_of(shop)
    offset = next(t for t in shop.physical if t.key == ("torque_offset", 0))
    lag, delay, offset = (score(t, shop.before.fit) for t in (lag_of(shop), delay, offset))
    quieter = calmed(lag.trial.effect, shop.unseen_by([lag.trial]).rows).sum()
    usual = decisive_between(shop, lag, offset)
    assert usual == shop.settings.decisive
    # As much as the estimate scatters by.
    assert decisive_between(shop, lag, delay) > usual + 0.12 * quieter
    assert 0.12 * quieter > 2 * usual


def test_a_lag_gains_nothing_on_a_delay_by_what_encoders_wander():
    shop = shop_of(data_set(4, repetitions=4, wander=0.4, late=LATE))
    fit = shop.before.fit
    worth = worth_beside((), shop.mean.rows)

    def found(name, chosen_by):
        best = score(trial_of(shop, name, None, (LATE,)), fit)
        for _ in range(4):
            context = shop.context_with(shop.fit([best.trial], bend=False))
            best = score(moved(best.trial, shop.mean.rows, context), fit)
            best = refine(best, fit, context, chosen_by)
        return best

    seeming = found("filter_lag", gain_of).gain - found("time_delay", gain_of).gain
    real = worth(found("filter_lag", worth)) - worth(found("time_delay", worth))
    assert seeming > 1000
    assert real < 0.05 * seeming


def test_beside_another_late_torque_noise_is_left_as_it_is(laid_out):
    shop, _ = laid_out
    late = [t for t in shop.physical if t.name in {"filter_lag", "time_delay"}]
    found = score(late[0], shop.before.fit)
    assert worth_beside(late[-1:], shop.mean.rows)(found) == found.gain
