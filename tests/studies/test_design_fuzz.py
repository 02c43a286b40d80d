"""Odd robots and odd wishes, a few of the many that `design_fuzz` runs by hand."""

from pathlib import Path

import pytest

from tests.studies.design_fuzz import Case, check

# Numbers whose runs end in each of the ways: a motion, a refusal, no usable result.
CASES = (0, 1, 3, 4, 5, 6)


@pytest.mark.parametrize("number", CASES)
def test_an_odd_robot_gets_a_motion_that_holds_or_one_line(number: int, tmp_path: Path) -> None:
    check(Case.number(number), tmp_path)
