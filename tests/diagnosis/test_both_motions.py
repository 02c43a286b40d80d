"""How uncertain a shape is that estimation and validation recordings decided together."""

import dataclasses

import numpy as np

from oed.diagnosis.candidates.open_shapes import decided
from oed.diagnosis.evidence.both_motions import narrowed
from oed.diagnosis.evidence.uncertainty import with_uncertainty
from oed.diagnosis.terms.scores import score
from tests.diagnosis.arm import data_set, stribeck
from tests.diagnosis.shop import shop_of, trial_of

REPLICATES = 4000
SIZES, SHAPES = 3, 2


def test_covariance_is_the_scatter_of_what_two_motions_decide():
    """Of a linear model, whose sizes the first motion alone gives at the shapes of both."""
    rng = np.random.default_rng(0)
    first, second = (rng.normal(size=(rows, SIZES + SHAPES)) for rows in (60, 40))
    first[:, SIZES:] = 0.9 * first[:, :SHAPES] + 0.15 * first[:, SIZES:]  # that leaves them open
    sizes, shapes = slice(0, SIZES), slice(SIZES, SIZES + SHAPES)
    follow = -np.linalg.pinv(first[:, sizes]) @ first[:, shapes]
    beside = first[:, shapes] + first[:, sizes] @ follow
    there = second[:, shapes] + second[:, sizes] @ follow
    found = []
    for _ in range(REPLICATES):
        noise, other = rng.normal(size=60), 1.5 * rng.normal(size=40)
        alone = np.linalg.pinv(first[:, sizes]) @ noise
        told = other - second[:, sizes] @ alone
        both = np.linalg.lstsq(
            np.concatenate([beside, there / 1.5]), np.concatenate([noise, told / 1.5]), rcond=None
        )[0]
        found.append(np.concatenate([alone + follow @ both, both]))
    covariance = np.linalg.inv(first.T @ first)
    stated = narrowed(covariance, shapes, second, np.full(40, 1.5**2))
    scatter = np.var(found, axis=0)
    # A variance from so many replicates is known to two per cent.
    np.testing.assert_allclose(np.diag(stated)[shapes], scatter[shapes], rtol=0.1)
    # Of the sizes it is no less, and no more than the first motion alone leaves.
    assert np.all(np.diag(stated)[sizes] > 0.9 * scatter[sizes])
    assert np.all(np.diag(stated) < np.diag(covariance))


def test_a_shape_known_beforehand_is_left_no_negative_variance():
    """Of two shapes, one known from the start and one that the second motion shows far better."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        spread = rng.normal(size=(4, 4)) * np.array([1.0, 1.0, 2e-4, 9e-12])[:, None]
        slopes = rng.normal(size=(30, 4)) * np.array([1.0, 1.0, 1e16, 1.0])
        stated = narrowed(spread @ spread.T, slice(2, 4), slopes, np.full(30, 2000.0))
        assert np.all(np.diag(stated) >= 0)


def test_what_validation_decided_is_known_better_than_from_the_estimation_alone():
    shop = shop_of(data_set(5, extra=stribeck(1.5)))
    fit = shop.before.fit
    begun = score(trial_of(shop, "stribeck", 0, (0.5, 4.0, 0.0)), fit)
    found = decided(shop, (), begun).trial
    assert found.decided
    both, alone = (
        np.sqrt(np.diag(with_uncertainty(shop, shop.fit([t])).covariances[0]))
        for t in (found, dataclasses.replace(found, decided=False))
    )
    assert np.all(both <= 1.01 * alone)
    assert both[0] < alone[0]
    (size,) = shop.fit([found]).coefficients[0]
    assert abs(size - 1.5) < 3 * both[0]
