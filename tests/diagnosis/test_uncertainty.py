"""Standard deviations of what is added, held against what estimates really scatter by."""

import dataclasses
from functools import cache, partial

import numpy as np
import pytest

from oed.diagnosis.candidates.crests import climbed, crests
from oed.diagnosis.evidence.doubt import doubtful_name
from oed.diagnosis.evidence.profile import left_by, profiled_deviation, widened
from oed.diagnosis.evidence.uncertainty import robust_covariance, with_uncertainty
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.tables.sharpening import sharpened
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import at_rest
from oed.diagnosis.terms.scores import Score, score
from oed.diagnosis.terms.secants import secants
from oed.diagnosis_new.noise.linear_fit import project
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.velocity_sign import widths_of, with_widths
from tests.diagnosis.arm import data_set, stribeck
from tests.diagnosis.shop import shop_of, trial_of

ROWS, BLOCK = 1200, 40


def ripple(size, harmonic):
    def torque(q, dq, ddq):
        return np.stack([np.zeros(len(q)), size * np.cos(harmonic * q[:, 1])], axis=1)

    return torque


def power(size, exponent):
    def torque(q, dq, ddq):
        own = size * np.sign(dq[:, 0]) * np.abs(dq[:, 0]) ** exponent
        return np.stack([own, np.zeros(len(q))], axis=1)

    return torque


def coupled(q, dq, ddq):
    own = 0.03 * ddq[:, 1] + 0.3 * dq[:, 1] + 0.4 * np.sign(dq[:, 1])
    return np.stack([own, np.zeros(len(q))], axis=1)


@cache
def shop_with(kind, seed=0):
    extra = {
        "ripple": ripple(0.3, 12.0),
        "stribeck": stribeck(1.5, 0.1),
        "power": power(4.4, 0.45),
        "coupled": coupled,
    }[kind]
    return shop_of(data_set(seed, extra=extra), held=False)


@pytest.mark.parametrize("colour", [0.0, 0.9])
def test_covariance_is_what_estimates_scatter_by_whatever_the_colour_of_the_misfit(colour):
    rng = np.random.default_rng(3)
    t = np.arange(ROWS) / BLOCK
    regressor = np.stack([np.cos(0.7 * t), np.sin(1.9 * t), np.ones(ROWS)], axis=1)[None]
    projection = project(regressor)
    truth = np.array([1.0, -2.0, 0.5])
    blocks = np.arange(ROWS) // BLOCK
    errors, stated = [], []
    for _ in range(150):
        noise = rng.standard_normal(ROWS + 200)
        for k in range(1, len(noise)):
            noise[k] += colour * noise[k - 1]
        y = regressor[0] @ truth + noise[200:]
        found = projection.inverse @ projection.coordinates(y[None])
        residual = projection.residual(y[None])
        covariance = robust_covariance(projection, residual, np.array([float(ROWS)]), blocks)
        errors.append(found - truth)
        stated.append(np.diag(covariance))
    scatter = np.std(errors, axis=0)
    np.testing.assert_allclose(np.sqrt(np.mean(stated, axis=0)), scatter, rtol=0.25)


def test_slope_of_a_ripple_over_its_harmonic_is_the_derivative_of_the_cosine():
    shop = shop_with("ripple")
    trial = trial_of(shop, "torque_ripple", 1, (12.0,))
    shape = CATALOGUE["torque_ripple"].shapes_for(shop.context, 1)[0]
    found = secants(
        trial, np.array([1.0, 0.0]), shop.mean.rows, shop.context, np.array([1e-4, 0.0])
    )
    fine = [
        (-p.motion.q[:, 1] * np.sin(12.0 * p.motion.q[:, 1]))[:, None]
        for p in shop.mean.rows.prepared
    ]
    expected = shop.mean.rows.whiten_fine(fine, 1)[:, 0] * (shape.upper - shape.lower)
    np.testing.assert_allclose(found[1, :, 0], expected, atol=2e-3 * np.abs(expected).max())


def test_uncertainty_of_a_harmonic_is_that_of_a_line_in_noise():
    shop = shop_with("ripple")
    trial = trial_of(shop, "torque_ripple", 1, (12.0,))
    whole = with_uncertainty(shop, shop.fit([trial]))
    shape = CATALOGUE["torque_ripple"].shapes_for(shop.context, 1)[0]
    stated = np.sqrt(whole.covariances[0][2, 2]) * (shape.upper - shape.lower)
    # Information on n of 0.3 cos(n q) where nothing else is to be estimated: the least it can be.
    fine = [
        (-0.3 * p.motion.q[:, 1] * np.sin(12.0 * p.motion.q[:, 1]))[:, None]
        for p in shop.mean.rows.prepared
    ]
    least = 1 / np.linalg.norm(shop.mean.rows.whiten_fine(fine, 1))
    assert least < stated < 3 * least


def test_shapes_come_to_rest_where_the_data_want_them_from_wherever_they_start():
    shop = shop_with("stribeck")
    fit = shop.before.fit
    # Hess and Soom's fall, as injected: no shape may end up fitting less well than the truth.
    truth = score(trial_of(shop, "stribeck", 0, (0.1, 2.0, 1.0)), fit)
    for start in ((0.02, 0.5, 0.0), (0.4, 4.0, 0.0), (0.05, 1.0, 1.0)):
        first = score(trial_of(shop, "stribeck", 0, start), fit)
        assert at_rest(first, fit, shop.context).gain > truth.gain - 0.1


def test_a_profile_is_the_slope_of_a_straight_model_and_wider_in_a_curved_valley():
    slope = partial(profiled_deviation, axis=0.5, deviation=0.01, noise=1.0)
    assert slope(lambda x: 700 + ((x - 0.5) / 0.01) ** 2) == pytest.approx(0.01, rel=1e-9)
    # Twice as uncertain where the rows that count are a quarter.
    squares = lambda x: ((x - 0.5) / 0.01) ** 2  # noqa: E731
    assert profiled_deviation(squares, 0.5, 0.01, 4.0) == pytest.approx(0.02, rel=0.05)
    # Of a fourth power of (x - 0.5) / 0.1 the squares have risen by four at sqrt(2) of it.
    quartic = slope(lambda x: ((x - 0.5) / 0.1) ** 4)
    assert quartic == pytest.approx(0.1 * np.sqrt(2) / 2, rel=0.05)
    # One side alone, at a bound; and no more than is known of nothing.
    # Two deviations beside the bottom, the interval of two reaches as far as it does about that.
    beside = profiled_deviation(lambda x: ((x - 0.52) / 0.01) ** 2, 0.5, 0.01, 1.0)
    assert beside == pytest.approx(0.02, rel=0.05)
    bounded = profiled_deviation(lambda x: (x / 0.05) ** 2, 0.0, 0.01, 1.0)
    assert bounded == pytest.approx(0.05, rel=0.05)
    assert slope(lambda x: 0.0) == pytest.approx(1 / np.sqrt(12))


def test_others_keep_what_they_are_known_to_once_the_widened_one_is_told():
    root = np.random.default_rng(5).normal(size=(4, 4))
    before = root @ root.T
    after = widened(before, 1, 3.0)
    assert after[1, 1] == pytest.approx(9 * before[1, 1])
    rest = [0, 2, 3]

    def told(c):
        return c[np.ix_(rest, rest)] - np.outer(c[rest, 1], c[1, rest]) / c[1, 1]

    np.testing.assert_allclose(told(after), told(before), atol=1e-12)


def test_a_shape_that_cannot_vary_leaves_what_is_known_of_the_sizes():
    shop = shop_with("coupled")
    # Of a two-joint arm without a wrist the motors' ratio has no range.
    trial = trial_of(shop, "motor_coupling", (0, 1), (0.0, 2.0))
    whole = with_uncertainty(shop, shop.fit([trial]))
    deviations = np.sqrt(np.diag(whole.covariances[0]))[:3]
    assert whole.coefficients[0] == pytest.approx([0.03, 0.3, 0.4], abs=4 * deviations.max())
    assert np.all(deviations < 0.1)
    assert doubtful_name(shop, whole) is None


def test_squares_of_a_profile_are_those_of_a_fit_with_the_shape_moved():
    shop = shop_with("ripple")
    trial = trial_of(shop, "torque_ripple", 1, (12.0,))
    layout = shop.layout(trial)
    columns = np.concatenate([layout.regressor, layout.nuisances], axis=2)
    squares = left_by(
        trial,
        project(columns),
        layout.torque,
        layout.rows,
        shop.context,
        steps=np.array([0.01, 0.0]),
    )
    shape = CATALOGUE["torque_ripple"].shapes_for(shop.context, 1)[0]
    for harmonic in (11.9, 12.0, 12.3):
        moved = trial_of(shop, "torque_ripple", 1, (harmonic,))
        expected = shop.fit([moved], layout, bend=False).fit.squares
        assert squares(0, shape.place_of(harmonic)) == pytest.approx(expected, rel=1e-9)


def test_of_two_crests_the_better_one_is_found():
    shop = shop_with("power")
    fit = shop.before.fit
    truth = score(trial_of(shop, "nonlinear_viscous", 0, (0.45, 0.0)), fit)
    # Viscous friction less a square of speed that thins: a crest of its own.
    other = score(trial_of(shop, "nonlinear_viscous", 0, (2.0, 3.0)), fit)
    stuck = at_rest(other, fit, shop.context)
    assert stuck.trial.values[0] > 1.5
    found = at_rest(climbed(shop, stuck, fit), fit, shop.context)
    assert found.gain > max(truth.gain - 0.1, stuck.gain + 10)
    assert found.trial.values[0] < 1.5


def test_crests_are_what_no_neighbour_exceeds():
    one, other = np.meshgrid(np.arange(8.0), np.arange(3.0), indexing="ij")
    gains = 9 * np.exp(-((one - 1) ** 2) - other**2) + 5 * np.exp(
        -((one - 6) ** 2) - (other - 2) ** 2
    )
    trial = trial_of(shop_with("ripple"), "torque_ripple", 1, (12.0,))
    scores = [
        Score(dataclasses.replace(trial, values=(a, b)), float(g), 2, np.ones(2))
        for a, b, g in zip(one.flat, other.flat, gains.flat, strict=True)
    ]
    assert [s.trial.values for s in crests(scores)] == [(1.0, 0.0), (6.0, 2.0)]


def test_a_sign_that_was_taken_for_slow_becomes_sharp_again():
    shop = shop_with("stribeck")
    least = shop.baseline.least_widths
    model = with_widths(shop.baseline.model, [50 * w for w in least])
    wide = shop.on(shop.baseline.with_model(model, shop.estimation))
    trial = trial_of(wide, "stribeck", 0, (0.1, 2.0, 1.0))
    again = sharpened(wide, [trial])
    assert again is not None
    assert max(widths_of(again.baseline.model)) < 5 * max(least)


def test_only_candidates_are_tried():
    shop = shop_with("ripple")
    few = dataclasses.replace(shop.settings, candidates=("torque_offset", "joint_spring"))
    restricted = Workshop(shop.baseline, shop.estimation, (), few)
    assert {t.name for t in restricted.physical} == {"torque_offset", "joint_spring"}
    with pytest.raises(ValueError, match="gremlin"):
        DiagnosisSettings(candidates=("gremlin",))


def test_a_share_of_a_torque_does_not_change_with_the_ratio_of_a_motor():
    """A step along the ratio leads to another formula, with other columns."""
    shop = shop_of(data_set(1, repetitions=1))
    share = trial_of(shop, "motor_coupling", (1, 0), (0.0, 3.0))
    steps = np.full(2, 0.1)
    along = secants(share, np.ones(1), shop.mean.rows, shop.context, steps)
    assert np.array_equal(along, np.zeros_like(along))
