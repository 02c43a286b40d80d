"""Numbers on a study's command line."""

import argparse

import pytest

from studies.whole_numbers import from_one, from_zero


@pytest.mark.parametrize(("kind", "least"), [(from_one, 1), (from_zero, 0)])
def test_a_number_from_the_least_on_is_taken(kind, least):
    assert [kind(str(least)), kind("37")] == [least, 37]


@pytest.mark.parametrize("text", ["-1", "2.5", "", "many", "nan"])
@pytest.mark.parametrize("kind", [from_one, from_zero])
def test_what_is_no_such_number_is_refused_with_what_was_given(kind, text):
    with pytest.raises(argparse.ArgumentTypeError, match="whole number from"):
        kind(text)


def test_there_must_be_one_at_least():
    with pytest.raises(argparse.ArgumentTypeError, match="'0' is no whole number from 1 on"):
        from_one("0")
