"""Standard deviations of what is added, held against what estimates really scatter by."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from oed.diagnosis.baseline.baseline import find_baseline
from oed.diagnosis.baseline.sign_width import widths_of, with_widths
from oed.diagnosis.data.prepare import prepare
from oed.diagnosis.evidence.uncertainty import robust_covariance, with_uncertainty
from oed.diagnosis.fit.linear_fit import project
from oed.diagnosis.search.scan import at_rest, score
from oed.diagnosis.search.workbench import secants
from oed.diagnosis.search.workshop import Workshop
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.terms.trials import catalogue_trial
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set, stribeck

ROWS, BLOCK = 1200, 40


def ripple(size, harmonic):
    def torque(q, dq, ddq):
        return np.stack([np.zeros(len(q)), size * np.cos(harmonic * q[:, 1])], axis=1)

    return torque


@cache
def shop_of(kind, seed=0):
    extra = {"ripple": ripple(0.3, 12.0), "stribeck": stribeck(1.5, 0.1)}[kind]
    dataset = data_set(seed, extra=extra)
    settings = DiagnosisSettings()
    prepared = prepare(dataset.recordings, settings)
    own = tuple(p for p in prepared if p.role == "estimation")
    baseline = find_baseline(TorqueModel.standard(dataset.robot), own)
    return Workshop(baseline, own, (), settings, gear_ratio=None)


def trial_of(shop, name, joint, values):
    return catalogue_trial(CATALOGUE[name], shop.context, joint, values, shop.mean.rows)


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
        covariance = robust_covariance(projection, residual, np.ones((ROWS, 1)), blocks)
        errors.append(found - truth)
        stated.append(np.diag(covariance))
    scatter = np.std(errors, axis=0)
    np.testing.assert_allclose(np.sqrt(np.mean(stated, axis=0)), scatter, rtol=0.25)


def test_slope_of_a_ripple_over_its_harmonic_is_the_derivative_of_the_cosine():
    shop = shop_of("ripple")
    trial = trial_of(shop, "torque_ripple", 1, (12.0,))
    (shape,) = CATALOGUE["torque_ripple"].shapes_for(shop.context, 1)
    found = secants(trial, np.array([1.0, 0.0]), shop.mean.rows, shop.context, np.array([1e-4]))
    fine = [
        (-p.motion.q[:, 1] * np.sin(12.0 * p.motion.q[:, 1]))[:, None]
        for p in shop.mean.rows.prepared
    ]
    expected = shop.mean.rows.whiten_fine(fine, 1)[:, 0] * (shape.upper - shape.lower)
    np.testing.assert_allclose(found[1, :, 0], expected, atol=2e-3 * np.abs(expected).max())


def test_uncertainty_of_a_harmonic_is_that_of_a_line_in_noise():
    shop = shop_of("ripple")
    trial = trial_of(shop, "torque_ripple", 1, (12.0,))
    whole = with_uncertainty(shop, shop.fit([trial]))
    (shape,) = CATALOGUE["torque_ripple"].shapes_for(shop.context, 1)
    stated = np.sqrt(whole.covariances[0][2, 2]) * (shape.upper - shape.lower)
    # Information on n of 0.3 cos(n q) where nothing else is to be estimated: the least it can be.
    fine = [
        (-0.3 * p.motion.q[:, 1] * np.sin(12.0 * p.motion.q[:, 1]))[:, None]
        for p in shop.mean.rows.prepared
    ]
    least = 1 / np.linalg.norm(shop.mean.rows.whiten_fine(fine, 1))
    assert least < stated < 3 * least


def test_shapes_come_to_rest_where_the_data_want_them_from_wherever_they_start():
    shop = shop_of("stribeck")
    fit = shop.before.fit
    # Hess and Soom's fall, as injected: no shape may end up fitting less well than the truth.
    truth = score(trial_of(shop, "stribeck", 0, (0.1, 2.0, 1.0)), fit.projection, fit.residual)
    for start in ((0.02, 0.5, 0.0), (0.4, 4.0, 0.0), (0.05, 1.0, 1.0)):
        first = score(trial_of(shop, "stribeck", 0, start), fit.projection, fit.residual)
        assert at_rest(first, fit, shop.context).gain > truth.gain - 0.1


def test_a_sign_that_was_taken_for_slow_becomes_sharp_again():
    shop = shop_of("stribeck")
    least = shop.baseline.least_widths
    model = with_widths(shop.baseline.model, [50 * w for w in least])
    wide = shop.on(shop.baseline.with_model(model, shop.estimation))
    trial = trial_of(wide, "stribeck", 0, (0.1, 2.0, 1.0))
    again = wide.sharpened([trial])
    assert again is not None
    assert max(widths_of(again.baseline.model)) < 5 * max(least)


def test_only_candidates_are_tried():
    shop = shop_of("ripple")
    few = dataclasses.replace(shop.settings, candidates=("torque_offset", "joint_spring"))
    restricted = Workshop(shop.baseline, shop.estimation, (), few, gear_ratio=None)
    assert {t.name for t in restricted.physical} == {"torque_offset", "joint_spring"}
    with pytest.raises(ValueError, match="gremlin"):
        DiagnosisSettings(candidates=("gremlin",))
