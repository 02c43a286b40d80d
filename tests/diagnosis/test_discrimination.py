"""Rivals: how far apart they are, and how often noise confuses them."""

import numpy as np
import pytest
from scipy.stats import ncx2, norm

from oed.diagnosis.rivals.confusion import confusion
from oed.diagnosis.rivals.discrimination import (
    _in_words,
    design_discriminating,
    error_rate,
    separation,
)
from oed.diagnosis.rivals.motions import as_prepared
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import dense
from tests.diagnosis.arm import data_set
from tests.diagnosis.shop import shop_of, trial_of


@pytest.fixture(scope="module")
def shop() -> Workshop:
    return shop_of(data_set(3, roles=("estimation", "estimation")))


def trial(shop, name, values=(), target=0):
    return trial_of(shop, name, target, values)


def outside(shop, *trials):
    """White columns of trials less their least-squares fit by model and nuisances, flat."""
    model = np.concatenate([shop.mean.regressor, shop.mean.nuisances], axis=2)
    model = model.reshape(-1, model.shape[2])
    columns = np.concatenate([dense(t, 2, shop.mean.rows.count) for t in trials], axis=2)
    columns = columns.reshape(len(model), -1)
    scaled = model / np.maximum(np.linalg.norm(model, axis=0), 1e-12)
    return columns - scaled @ np.linalg.lstsq(scaled, columns, rcond=1e-9)[0]


def scaled_pair(shop, wanted):
    """A favourite whose lambda against its rival is as wanted, and the angle between both."""
    own, other = trial(shop, "torque_offset"), trial(shop, "asymmetric_viscous")
    lengths = np.linalg.norm(columns := outside(shop, own, other), axis=0)
    cosine = abs(columns[:, 0] @ columns[:, 1]) / lengths.prod()
    size = np.sqrt(wanted / (1 - cosine**2)) / lengths[0]
    return (own, np.array([size]), other), np.arccos(cosine)


def test_error_rate_is_that_of_two_models_without_freedom() -> None:
    rng = np.random.default_rng(0)
    one, two = rng.normal(size=(2, 50))
    one, two = (1.8 * x / np.linalg.norm(one - two) for x in (one, two))
    y = one + rng.normal(size=(100_000, 50))
    wrong = np.mean(np.sum((y - two) ** 2, axis=1) < np.sum((y - one) ** 2, axis=1))
    apart = float(np.sum((one - two) ** 2))
    assert error_rate(apart) == pytest.approx(wrong, abs=0.005)


def test_separation_is_what_least_squares_leaves_of_all_recordings(shop: Workshop) -> None:
    pair, _ = scaled_pair(shop, 7.0)
    assert separation(shop, *pair) == pytest.approx(7.0, rel=1e-4)
    own, size, other = pair
    left = outside(shop, own)[:, 0] * size
    rival = outside(shop, other)[:, 0]
    left -= rival * (rival @ left) / (rival @ rival)
    assert separation(shop, *pair) == pytest.approx(left @ left, rel=1e-4)


def test_a_rivals_shape_is_searched_over_its_range(shop: Workshop) -> None:
    own = trial(shop, "position_dependent_friction", (6.0,))
    far = trial(shop, "position_dependent_friction", (1.0,))
    coefficients = np.array([0.3, 0.1])
    own_squares = np.sum((outside(shop, own) @ coefficients) ** 2)
    # The same effect with its shape elsewhere: nothing stands between them.
    assert separation(shop, own, coefficients, far) < 0.02 * own_squares


@pytest.mark.parametrize("wanted", [0.5, 3.0, 8.0])
def test_confusion_is_the_closed_form_of_two_directions(shop: Workshop, wanted: float) -> None:
    pair, angle = scaled_pair(shop, wanted)
    length = np.sqrt(wanted) / np.sin(angle)
    # Of two unit vectors the one with the larger product wins: the signs of the products with
    # their sum and their difference, independent of each other, decide.
    a, b = norm.cdf([-length * np.cos(angle / 2), -length * np.sin(angle / 2)])
    found = confusion(shop, pair, np.random.default_rng(1), draws=4000, truths=1)
    assert found.by_fit == pytest.approx(a + b - 2 * a * b, abs=0.03)


@pytest.mark.parametrize("wanted", [4.0, 12.0])
def test_a_decisive_lead_is_foreseen_as_often_as_it_comes(shop: Workshop, wanted: float) -> None:
    pair, angle = scaled_pair(shop, wanted)
    length = np.sqrt(wanted) / np.sin(angle)
    rng = np.random.default_rng(5)
    # Both cost one parameter, and what they cancel against the model is the same in every draw.
    own, other = (outside(shop, t)[:, 0] for t in pair[::2])
    whole = [dense(t, 2, shop.mean.rows.count).ravel() for t in (pair[0], pair[2])]
    cancelled = [(b @ b) / (c @ c) for b, c in zip(whole, (own, other), strict=True)]
    x, y = rng.normal(size=(2, 200_000))
    along = (length + x, (length + x) * np.cos(angle) + y * np.sin(angle))
    one, two = (a**2 - np.log(c) for a, c in zip(along, cancelled, strict=True))
    smoothing = 0.01 * np.maximum(along[0] ** 2, along[1] ** 2)
    expected = np.mean(one - two >= np.maximum(shop.settings.decisive, smoothing))
    found = confusion(shop, pair, np.random.default_rng(1), draws=4000, truths=1)
    assert found.resolved == pytest.approx(expected, abs=0.03)


def test_what_the_data_leave_open_makes_the_prediction_less_sure(shop: Workshop) -> None:
    own = trial(shop, "position_dependent_friction", (6.0,))
    other = trial(shop, "torque_ripple", (6.0,))
    size = 4.0 / np.linalg.norm(outside(shop, own)[:, 0])
    pair = (own, np.array([size, 0.0]), other)
    sure, open_ = (
        confusion(shop, pair, np.random.default_rng(4), truths=k).resolved for k in (1, 8)
    )
    assert 0.05 < open_ < sure < 0.95


def test_the_price_of_shapes_counts_for_the_name_alone(shop: Workshop) -> None:
    own = trial(shop, "torque_ripple", (9.0,))
    columns = outside(shop, own)
    coefficients = np.array([1.0, 0.0]) * 2.0 / np.linalg.norm(columns[:, 0])
    cheap = trial(shop, "torque_offset")
    found = confusion(
        shop, (own, coefficients, cheap), np.random.default_rng(2), draws=200, truths=1
    )
    # A ripple searched over all periods always fits better; its price gives the name away. Of a
    # known period the gain is a chi-square of two columns, and the ripple costs two parameters
    # more; the search over periods near its own wins back a few of the draws.
    known = ncx2.cdf(2 * np.log(shop.mean.rows.count), 2, 2.0**2)
    chance = 3 * np.sqrt(known * (1 - known) / 200)
    assert found.by_fit < 0.1
    assert known - 0.1 < found.by_name < known + chance


def test_a_rival_is_drawn_at_the_shape_that_imitates_best(shop: Workshop) -> None:
    own = trial(shop, "position_dependent_friction", (6.1,))
    far = trial(shop, "position_dependent_friction", (1.0,))
    # The same effect, searched from elsewhere: noise alone decides which of both fits better.
    pair = (own, np.array([1.5, 0.5]), far)
    found = confusion(shop, pair, np.random.default_rng(3), draws=200, truths=1)
    assert 0.2 < found.by_fit < 0.8


def test_a_further_motion_sets_rivals_further_apart(shop: Workshop) -> None:
    pair, _ = scaled_pair(shop, 4.0)
    pattern = shop.mean.rows.prepared[0]
    again = as_prepared(pattern, pattern.motion)
    assert separation(shop, *pair, again) > separation(shop, *pair)
    following = design_discriminating(shop, [pair], np.random.default_rng(0), candidates=6)
    assert following.separation > following.separation_now == pytest.approx(4.0, rel=1e-3)
    assert following.error_rate < following.error_rate_now
    assert 0.0 < following.resolved <= 1.0
    # As long as a repetition at hand, so that noise can be read off both.
    step = following.motion.t[1] - following.motion.t[0]
    assert len(following.motion) * step == pytest.approx(shop.estimation[0].period, abs=2 * step)


def test_refuses_to_choose_among_no_motions(shop: Workshop) -> None:
    pair, _ = scaled_pair(shop, 4.0)
    with pytest.raises(ValueError, match="0 motions leave nothing"):
        design_discriminating(shop, [pair], np.random.default_rng(0), candidates=0)


def test_rivals_of_one_name_are_told_by_their_joints(shop: Workshop) -> None:
    first, second = (trial_of(shop, "torque_offset", joint) for joint in (0, 1))
    assert _in_words(first, second) == "torque_offset on joint 1 or on joint 2"
    assert _in_words(first, trial_of(shop, "joint_spring", 0)) == "torque_offset or joint_spring"
