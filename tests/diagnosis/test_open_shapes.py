"""Shapes that estimation and validation recordings decide together."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.candidates.open_shapes import MISFIT, decided
from oed.diagnosis.search import next_name, selection
from oed.diagnosis.terms.scores import inflation_of, score
from tests.diagnosis.arm import data_set, stribeck
from tests.diagnosis.shop import shop_of, trial_of

WRONG = (0.5, 4.0, 0.0)  # speed, exponent and tail far from those of the data


@pytest.fixture(scope="module")
def shop():
    return shop_of(data_set(10, extra=stribeck(1.5)))


def foretold(shop, trial):
    """Squares that a whole refit leaves of each joint's validation rows, in rows that count."""
    unseen = shop.unseen_by([trial])
    return unseen.left(shop.fit([trial], shop.layout(trial), bend=False)) / unseen.counted


def test_a_shape_is_decided_by_both_motions(shop):
    fit = shop.before.fit
    begun = score(trial_of(shop, "stribeck", 0, WRONG), fit)
    found = decided(shop, (), begun)
    first, unit = foretold(shop, begun.trial), np.maximum(foretold(shop, begun.trial), 1.0)
    assert first[0] > MISFIT

    def told(tried):
        """Of both, by fits of all parameters."""
        left = foretold(shop, tried.trial) * shop.unseen.counted
        return tried.gain / inflation_of(fit)[0] - np.sum(left / unit)

    right = score(trial_of(shop, "stribeck", 0, (0.1, 2.0, 0.0)), fit)
    assert told(found) > told(begun) + 10
    assert told(found) > told(right) - 2
    assert foretold(shop, found.trial)[0] < 1.2


def test_a_shape_that_foretells_stays_as_it_is(shop):
    fit = shop.before.fit
    right = decided(shop, (), score(trial_of(shop, "stribeck", 0, WRONG), fit))
    assert decided(shop, (), right) is right
    offset = score(trial_of(shop, "torque_offset", 0), fit)
    assert decided(shop, (), offset) is offset


def test_what_explains_nothing_at_the_shape_decided_for_it_is_no_candidate(monkeypatch):
    """A free form explains infinitely many times as much as that."""
    silent = []

    def decided_to_nothing(shop, candidates, others):
        silent.extend(dataclasses.replace(c, gain=0.0) for c in candidates)
        return silent

    monkeypatch.setattr(next_name, "most_telling_first", decided_to_nothing)
    _, chosen = selection.search(shop_of(data_set(10, extra=stribeck(1.5))))
    assert silent
    assert all(a.trial.is_free_form for a in chosen.accepted)


@pytest.mark.parametrize(("hardening", "near", "kept"), [(0.0, 0.15, 1.0), (3.0, 1.0, 2.0)])
def test_further_terms_of_a_formula_stay_only_where_another_motion_shows_them(
    hardening, near, kept
):
    """Near the middle a cube is hardly seen, and what noise makes of it is large further out."""

    def spring(q, dq, ddq):
        pull = 3.0 * q[:, 1] + hardening * q[:, 1] ** 3
        return np.stack([np.zeros(len(q)), pull], axis=1)

    shop = shop_of(data_set(4, extra=spring, near=near))
    fuller = score(trial_of(shop, "joint_spring", 1, (2.0,)), shop.before.fit)
    found = decided(shop, [], fuller)
    assert found.trial.values == (kept,)
    errors = [shop.unseen_error([s.trial]) for s in (fuller, found)]
    assert errors[1] <= errors[0]
