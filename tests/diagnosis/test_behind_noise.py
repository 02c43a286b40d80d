"""An effect that passes for slow noise, and the noise beside it."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.search.behind_noise import quieter_beside
from oed.diagnosis.search.selection import search
from oed.dynamics.effects.entries.payload import SWING
from tests.diagnosis.arm import RATE, data_set, once, rigid
from tests.diagnosis.shop import shop_of

LOAD = (0.0, 0.12, 0.02, 0.05)  # base parameters that a load adds to the arm's
TAKEN_UP = 9.0  # [s]
NAMES = ("payload_change", "thermal_drift", "torque_offset", "stribeck", "torque_ripple")


def load_from(*moments):
    """Torque of a load that each recording in turn holds from some moment on [s]."""
    since = iter(moments)

    def torque(q, dq, ddq):
        held = np.arange(len(q)) / RATE > next(since)
        return held[:, None] * rigid(q, dq, ddq, LOAD)

    return torque


def dazed_shop(extra):
    """Recordings that nobody repeated, and noise of which hardly a row in a hundred counts."""
    dataset = data_set(1, extra=extra, roles=("estimation", "validation"), repetitions=2)
    bare = tuple(map(once, dataset.recordings))
    shop = shop_of(
        dataclasses.replace(dataset, recordings=bare), surrogates=39, refined=4, candidates=NAMES
    )
    floor = dataclasses.replace(shop.baseline.floor, dilution=np.full(2, 300.0))
    return shop.on(dataclasses.replace(shop.baseline, floor=floor))


def test_a_load_that_passes_for_noise_is_named():
    shop, selection = search(dazed_shop(load_from(TAKEN_UP, 0.0)))
    assert [t.name for t in selection.trials] == ["payload_change"]
    assert selection.trials[0].values[0] == pytest.approx(TAKEN_UP, abs=SWING)
    assert np.all(shop.baseline.floor.dilution < 3.0)


def test_noise_that_is_noise_stays_so():
    _, selection = search(dazed_shop(None))
    assert selection.trials == ()


def test_noise_of_rows_that_count_is_not_suspected():
    dataset = data_set(1, roles=("estimation", "validation"), repetitions=2)
    shop = shop_of(dataset, surrogates=39, refined=4, candidates=NAMES)
    assert not list(quieter_beside(shop, shop.physical, ()))


def warming_shop(size, constant):
    """Three repetitions of an arm whose second joint warms up during the first."""

    def extra(q, dq, ddq):
        cold = size * np.exp(-np.arange(len(q)) / RATE / constant)
        return np.stack([0 * cold, cold * np.sign(dq[:, 1])], axis=1)

    dataset = data_set(2, extra=extra, roles=("estimation", "validation"))
    return shop_of(dataset, surrogates=39, refined=4, candidates=NAMES)


def test_friction_that_warms_up_in_one_repetition_is_no_noise():
    shop = warming_shop(1.4, 6.0)
    found = list(quieter_beside(shop, shop.physical, ()))
    beside, trial = found[0]
    assert trial.key == ("thermal_drift", 1)
    assert trial.values[0] == pytest.approx(6.0, rel=0.2)
    # What is left is the noise of an arm that does not warm up.
    cool = warming_shop(0.0, 6.0).baseline.floor.deviation[1]
    assert shop.baseline.floor.deviation[1] > 1.5 * cool
    assert beside.baseline.floor.deviation[1] == pytest.approx(cool, rel=0.05)


def test_noise_that_differs_between_repetitions_is_noise():
    dataset = data_set(5, colour=0.3, roles=("estimation", "validation"))
    shop = shop_of(dataset, surrogates=39, refined=4, candidates=NAMES)
    assert not list(quieter_beside(shop, shop.physical, ()))
