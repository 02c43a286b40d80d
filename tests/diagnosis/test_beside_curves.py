"""What is read anew beside terms without a name, and terms anew where names fell."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.search.free_form_rivals import better_free_form
from oed.diagnosis.search.name_search import NameSearch
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.search.selection import with_stand_ins
from oed.diagnosis.terms.scores import score
from oed.diagnosis.terms.trials import Trial, catalogue_trial
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.velocity_sign import widths_of, with_widths
from tests.diagnosis.arm import RATE, data_set, stribeck
from tests.diagnosis.shop import shop_of, trial_of

SLOW = 0.05  # [rad/s] over which no joint of this arm turns


@pytest.fixture(scope="module")
def waving():
    """A torque of the first joint in waves of the second one's position."""

    def extra(q, dq, ddq):
        return np.stack([1.5 * np.cos(3 * q[:, 1]), 0 * q[:, 1]], axis=1)

    return shop_of(data_set(1, extra=extra), surrogates=39, refined=4)


def curve_of(shop) -> Trial:
    fit = shop.before.fit
    own = (t for t in shop.smooth if t.joint == 0 and not t.between_repetitions)
    return max(own, key=lambda t: score(t, fit).gain)


def test_signs_are_read_off_again_beside_a_curve(waving):
    model = waving.baseline.model
    slow = with_widths(model, [SLOW, SLOW])
    state = NameSearch(
        waving.on(dataclasses.replace(waving.baseline, model=slow)), [], upright=False
    )
    curve = Accepted(curve_of(state.shop), 1e4)
    assert not state.sharpen([])
    assert state.sharpen([curve])
    assert max(widths_of(state.shop.baseline.model)) < SLOW / 2
    # Once: what comes of it is another curve, and would turn in circles.
    assert not state.sharpen([curve])


def test_signs_stay_where_a_curve_changes_nothing(waving):
    state = NameSearch(waving, [], upright=False)
    assert not state.sharpen([Accepted(curve_of(waving), 1e4)])
    assert state.shop is waving


def test_curves_are_found_anew_where_a_name_fell(waving):
    stale = Accepted(curve_of(waving), 1e4, stands_in=False)
    offset = Accepted(trial_of(waving, "torque_offset", 1), 50.0)
    before = Selection.of(waving, [offset, stale], [])
    after = with_stand_ins(waving, before)
    assert after.trials[0].key == ("torque_offset", 1)
    (term,) = after.trials[1:]
    assert (term.joint, term.effect.depends_on) == (0, ("q_2",))
    left = [np.sum(s.found.fit.residual[0] ** 2) for s in (before, after)]
    assert left[1] < 0.1 * left[0]


def test_a_curve_is_no_rival_of_what_differs_between_repetitions():
    """Friction that falls with speed and with time: no function of speed explains the latter."""
    fades = 8.0  # [s]

    def extra(q, dq, ddq):
        t = np.arange(len(q)) / RATE
        drift = 0.3 * np.exp(-t / fades) * np.sign(dq[:, 1])
        return stribeck(1.5, joint=1)(q, dq, ddq) + drift[:, None] * [0, 1]

    shop = shop_of(data_set(2, extra=extra), surrogates=39, refined=4)
    fit = shop.fit((), shop.full).fit
    entry = CATALOGUE["thermal_drift"]
    drift = score(catalogue_trial(entry, shop.context, 1, (fades, 0.0), shop.full.rows), fit)
    curves = [s for s in ranked(shop, shop.smooth, (), 4) if s.trial.effect.depends_on == ("dq_2",)]
    assert curves[0].gain > 2 * drift.gain > 0
    assert better_free_form(shop, drift, curves, ()) is None
