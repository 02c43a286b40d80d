"""A name that falls takes with it what settled beside it."""

import dataclasses

import pytest

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.search.name_search import NameSearch
from tests.diagnosis.arm import data_set, stribeck
from tests.diagnosis.shop import shop_of, trial_of

HOME, ASIDE = (0.1, 2.0, 0.0), (0.4, 1.0, 0.0)  # speed, exponent and tail


@pytest.fixture
def state():
    """A search in which an offset that is not there has pulled another name aside."""
    shop = shop_of(data_set(10, extra=stribeck(1.5)))
    names = [
        Accepted(trial_of(shop, name, 0, values), 100.0)
        for name, values in (
            ("stribeck", HOME),
            ("stribeck", ASIDE),
            ("torque_offset", ()),
        )
    ]
    home, aside, offset = names
    found = NameSearch(shop, [], upright=False, accepted=[aside, offset])
    found.history = [(shop, []), (shop, [home]), (shop, [aside, offset])]
    return found


def test_the_others_are_as_they_were_before_it_came(state):
    _, (_, (home,)), _ = state.history
    aside, offset = state.accepted
    state.give_up({offset.trial.key}, [aside])
    assert state.accepted == [home]
    assert offset.trial.key in state.barred


def test_names_that_never_stood_alone_stay_as_they_are(state):
    aside, offset = state.accepted
    state.history = [(state.shop, []), (state.shop, [offset])]
    state.give_up({offset.trial.key}, [aside])
    assert state.accepted == [aside]


def test_tables_come_back_with_the_names(state):
    first = state.shop
    state.shop = first.on(dataclasses.replace(first.baseline))
    aside, offset = state.accepted
    state.give_up({offset.trial.key}, [aside])
    assert state.shop is first
