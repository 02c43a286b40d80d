"""A name that falls takes with it what settled beside it, and a tilt all that was found under it."""

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
    return with_history(NameSearch(shop, [], False, [aside, offset]), [], [home], [aside, offset])


def with_history(search, *steps):
    """A search that came by these names, on the tables that it has."""
    search.history = [NameSearch(search.shop, [], False, step) for step in steps]
    return search


def test_the_others_are_as_they_were_before_it_came(state):
    (home,) = state.history[1].accepted
    aside, offset = state.accepted
    state.give_up({offset.trial.key}, [aside])
    assert state.accepted == [home]
    assert offset.trial.key in state.barred


def test_names_that_never_stood_alone_stay_as_they_are(state):
    aside, offset = state.accepted
    with_history(state, [], [offset])
    state.give_up({offset.trial.key}, [aside])
    assert state.accepted == [aside]


def test_tables_come_back_with_the_names(state):
    first = state.shop
    state.shop = first.on(dataclasses.replace(first.baseline))
    aside, offset = state.accepted
    state.give_up({offset.trial.key}, [aside])
    assert state.shop is first


def test_without_a_tilt_the_search_goes_on_from_where_it_was_named(state):
    level, (home,) = state.shop, state.history[1].accepted
    aside, offset = state.accepted
    state.history[1].barred, state.history[1].paired = {("backlash", 1)}, {0}
    state.shop = level.on(dataclasses.replace(level.baseline))
    state.shop.declared = level.baseline
    state.history[2].shop = state.shop
    goes_on = state.before_tilt()
    assert goes_on is not None
    assert goes_on.upright
    assert goes_on.shop is level
    assert goes_on.accepted == [home]
    assert (goes_on.barred, goes_on.paired) == ({("backlash", 1)}, {0})
    goes_on.accepted.append(offset)  # what it does is not what was
    assert state.history[1].accepted == [home]
    assert with_history(state, [], [aside]).before_tilt() is None  # turned from the start
