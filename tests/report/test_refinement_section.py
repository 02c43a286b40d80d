"""What a page says of the gap between the fits by inverse dynamics and by simulation."""

import pytest

from oed.report.page import Text
from oed.report.refinement_section import refinement_section


def told(distance):
    record = {
        "accepted": True, "errors": [], "distance": distance, "allowed": 21.0, "windows": 8,
        "directions": 12, "status": "Solve_Succeeded",
    }  # fmt: skip
    blocks = refinement_section(record).blocks
    return " ".join(block.text for block in blocks if isinstance(block, Text))


def test_a_short_distance_is_not_taken_for_the_right_class_of_model():
    text = told(3.0)
    assert "does not show that the class of model is right" in text
    assert "prior" in text
    assert "is wrong" not in text


def test_a_long_distance_is_one_that_noise_does_not_make():
    assert "the class of model is wrong" in told(300.0)
    assert "does not show" not in told(300.0)


@pytest.mark.parametrize("distance", [3.0, 300.0])
def test_both_numbers_are_told(distance):
    assert f"{distance:.3g}" in told(distance)
    assert "below 21 in 95 % of cases or more" in told(distance)
