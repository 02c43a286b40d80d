"""What is told of shapes that the data leave open, or that lie near what machines are built with."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.candidates.usual import as_usual
from oed.diagnosis.evidence.estimates import estimates
from oed.diagnosis.evidence.profile import UNIFORM, widened
from oed.diagnosis.terms.climbing import at_rest
from oed.diagnosis.terms.scores import score
from oed.dynamics.effects.catalogue import CATALOGUE
from tests.diagnosis.arm import COULOMB, data_set
from tests.diagnosis.shop import shop_of, trial_of

WAVE = "position_dependent_friction"


def uneven(harmonic, share):
    """Friction of the first joint that varies with its position."""

    def torque(q, dq, ddq):
        return share * COULOMB * np.cos(harmonic * q) * np.sign(dq) * [1.0, 0.0]

    return torque


@pytest.mark.parametrize("place", [0.0, 0.3, 1.0])
def test_the_interval_of_an_unknown_shape_holds_its_range(place):
    """Wherever in the range the best value lies: the truth may lie anywhere in it."""
    shop = shop_of(data_set(7))
    trial = trial_of(shop, WAVE, 0)
    shape = CATALOGUE[WAVE].shapes_for(shop.context, 0)[0]
    value = shape.lower + place * (shape.upper - shape.lower)
    trial = dataclasses.replace(trial, values=(value, *trial.values[1:]))
    known = np.diag([0.01, 0.01, 0.03**2, 0.0])
    unknown = widened(known, 2, UNIFORM / 0.03)  # as a flat profile has it, to a rounding error
    told = estimates(shop, trial, np.ones(2), unknown)
    (std,) = (p.std for p in told if p.name == shape.name)
    true = np.random.default_rng(0).uniform(shape.lower, shape.upper, 100_000)
    assert std**2 == pytest.approx(np.mean((true - value) ** 2), rel=0.02)
    assert np.mean(np.abs(true - value) < 1.96 * std) > 0.95


@pytest.mark.parametrize(("harmonic", "share", "is_whole"), [(2.0, 0.2, True), (2.5, 0.6, False)])
def test_friction_comes_a_whole_number_of_times_a_turn_unless_the_data_ask_for_another(
    harmonic, share, is_whole
):
    shop = shop_of(data_set(3, extra=uneven(harmonic, share)))
    trial = trial_of(shop, WAVE, 0, (harmonic,))
    fit = shop.fit((), shop.layout(trial)).fit
    best = at_rest(score(trial, fit), fit, shop.context)
    told = as_usual(shop, [], best, fit).trial.values[0]
    if is_whole:
        assert best.trial.values[0] != told == harmonic
    else:
        assert told == best.trial.values[0] == pytest.approx(harmonic, rel=0.03)


@pytest.mark.parametrize(("share", "is_told"), [(0.0, False), (0.4, True)])
def test_a_formula_that_holds_by_choice_has_no_deviation(share, is_told):
    shop = shop_of(data_set(7))
    trial = trial_of(shop, "load_dependent_friction", 0, (share,))
    told = estimates(shop, trial, np.ones(1), np.diag([0.01, 0.03**2, 0.0]))
    assert (next(p.std for p in told if p.name == "share") > 0) is is_told
