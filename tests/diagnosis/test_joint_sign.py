"""A sign that turns slowly and a law of low speed on the same joint are told from each other."""

import numpy as np
import pytest

from oed.diagnosis.candidates.usual import as_usual
from oed.diagnosis.evidence.sharper_sign import told_by_a_sign
from oed.diagnosis.tables import sharpening
from oed.diagnosis.tables.sharpening import sharpened
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import at_rest
from oed.diagnosis.terms.scores import score
from oed.dynamics.velocity_sign import widths_of, with_widths
from tests.diagnosis.arm import COULOMB, data_set
from tests.diagnosis.shop import shop_of, trial_of

WIDTH = 0.08  # [rad/s] over which the first joint's friction turns
RISE, SPEED = 2.5, 0.5  # of friction towards standstill [N m], and where it has gone [rad/s]


def gaussian(x):
    return np.exp(-(x**2))


def lorentzian(x):
    return 1 / (1 + x**2)


def friction(decay, largest=RISE):
    """What the first joint's friction differs by from one that switches at once."""

    def torque(q, dq, ddq):
        turn = np.tanh(dq / WIDTH)
        rising = largest * decay(np.abs(dq) / SPEED) * turn
        return (COULOMB * (turn - np.sign(dq)) + rising) * [1.0, 0.0]

    return torque


def standing_on(shop: Workshop, width: float) -> Workshop:
    """The same tables with a sign that turns over this width, whatever the data say."""
    widths = [width, *shop.baseline.least_widths[1:]]
    model = with_widths(shop.baseline.model, widths)
    return shop.on(shop.baseline.with_model(model, shop.estimation))


@pytest.fixture(scope="module")
def shop():
    return shop_of(data_set(6, extra=friction(gaussian)))


@pytest.mark.parametrize("wrong", [0.002, 0.12])
def test_width_and_rise_come_out_together_from_a_wrong_width(shop, wrong):
    """Fitted in turn, each stays where the other stands: beside 0.12 rad/s the rise is 4.3 N m."""
    astray = standing_on(shop, wrong)
    trial = trial_of(astray, "stribeck", 0, (0.8, 1.0, 0.0))
    fit = astray.fit((), astray.layout(trial)).fit
    found = at_rest(score(trial, fit), fit, astray.context)
    right = sharpened(astray, [found.trial])
    assert right is not None
    assert widths_of(right.baseline.model)[0] == pytest.approx(WIDTH, rel=0.15)
    fit = right.fit((), right.layout(trial)).fit
    settled = at_rest(score(right.renewed(found.trial), fit), fit, right.context)
    (rise,) = settled.coefficients
    # A tenth: some five deviations that the data leave of it.
    assert rise == pytest.approx(RISE, rel=0.1)
    assert settled.trial.values[0] == pytest.approx(SPEED, rel=0.1)


@pytest.mark.parametrize(("decay", "is_plain"), [(gaussian, True), (lorentzian, False)])
def test_the_plain_formula_holds_unless_the_data_ask_for_another(decay, is_plain):
    shop = standing_on(shop_of(data_set(6, extra=friction(decay, 2 * RISE))), WIDTH)
    trial = trial_of(shop, "stribeck", 0, (SPEED, 1.5, 0.5))
    fit = shop.fit((), shop.layout(trial)).fit
    best = at_rest(score(trial, fit), fit, shop.context)
    tail = as_usual(shop, [], best, fit).trial.values[2]
    assert (tail == 0.0) is is_plain


@pytest.mark.parametrize(("turns", "kept"), [(WIDTH, True), (0.0, False)])
def test_a_slow_sign_must_foretell_the_validation_recordings(turns, kept, monkeypatch):
    """Whatever the estimation recordings say: they may seldom turn slowly, and others do."""

    def creeping(q, dq, ddq):
        turn = np.tanh(dq / turns) if turns else np.sign(dq)
        return COULOMB * (turn - np.sign(dq)) * [1.0, 0.0]

    shop = shop_of(data_set(6, extra=creeping))
    slow = with_widths(shop.baseline.model, [WIDTH, *shop.baseline.least_widths[1:]])
    monkeypatch.setattr(sharpening, "_signs_beside", lambda *_: slow)
    found = sharpened(standing_on(shop, WIDTH / 2), [])
    assert found is not None
    expected = WIDTH if kept else shop.baseline.least_widths[0]
    assert widths_of(found.baseline.model)[0] == pytest.approx(expected)


@pytest.mark.parametrize(("rise", "is_told"), [(0.0, True), (RISE, False)])
def test_a_law_that_mends_a_sign_that_it_has_made_too_slow_is_none(rise, is_told):
    """Friction that rises towards standstill by what a slow sign takes away from it."""

    def rising(q, dq, ddq):
        return rise * gaussian(np.abs(dq) / SPEED) * np.sign(dq) * [1.0, 0.0]

    shop = standing_on(shop_of(data_set(6, extra=rising)), WIDTH)
    values = (WIDTH, 1.0, 0.0) if is_told else (SPEED, 2.0, 0.0)
    trial = trial_of(shop, "stribeck", 0, values)
    whole = shop.fit([trial], bend=False)
    gain = shop.fit((), bend=False).fit.squares - whole.fit.squares
    assert gain > 100.0  # it looks like a find
    assert (told_by_a_sign(shop, whole) is not None) is is_told
