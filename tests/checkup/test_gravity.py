"""Gravity declared with a wrong sign or in another unit is found with what should stand there."""

import pytest

from oed.checkup.gravity import gravity_finding
from tests.checkup.simulated_arm import dataset, model_of, processed


def errors(found):
    return [float(str(row["held-out error / torque"])) for row in found.rows]


def found_with(gravity):
    data = dataset(gravity=gravity)
    return gravity_finding(data, model_of(data.robot), processed(data))


def test_the_true_gravity_is_left_alone():
    found = found_with((0.0, 0.0, -9.81))
    assert found.level == "green"
    # The other sign is much worse, which the table shows.
    declared, reversed_one = errors(found)[:2]
    assert reversed_one > 3 * declared


@pytest.mark.parametrize("wrong", [(0.0, 0.0, 9.81), (0.0, 0.0, -981.0), (0.0, 0.0, 981.0)])
def test_a_wrong_sign_and_a_wrong_unit_are_told_with_the_right_value(wrong):
    found = found_with(wrong)
    assert found.level == "red"
    assert found.remedy.startswith("declare gravity = [")
    tried = [str(row["[m/s^2]"]).replace("-0", "0") for row in found.rows]
    assert errors(found)[tried.index("0, 0, -9.81")] == min(errors(found))
    assert "-9.81]" in found.remedy
    if abs(wrong[2]) > 10:
        assert "100 times that on Earth" in found.text
    else:
        assert "reversed" in found.text
