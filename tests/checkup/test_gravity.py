"""Gravity declared with a wrong sign or in another unit is found with what should stand there."""

import pytest

from oed.checkup.gravity import gravity_finding
from tests.checkup.simulated_arm import dataset, model_of, processed


def found_with(gravity):
    data = dataset(gravity=gravity)
    return gravity_finding(data, model_of(data.robot), processed(data))


def test_the_true_gravity_is_left_alone():
    found = found_with((0.0, 0.0, -9.81))
    assert found.level == "green"
    # The other sign is much worse, which the table shows.
    assert found.rows[1]["held-out error / torque"] > 3 * found.rows[0]["held-out error / torque"]


@pytest.mark.parametrize("wrong", [(0.0, 0.0, 9.81), (0.0, 0.0, -981.0), (0.0, 0.0, 981.0)])
def test_a_wrong_sign_and_a_wrong_unit_are_told_with_the_right_value(wrong):
    found = found_with(wrong)
    assert found.level == "red"
    assert found.remedy.startswith("declare gravity = [")
    right = next(row for row in found.rows if row["[m/s^2]"].replace("-0", "0") == "0, 0, -9.81")
    assert right["held-out error / torque"] == min(r["held-out error / torque"] for r in found.rows)
    assert "-9.81]" in found.remedy
    if abs(wrong[2]) > 10:
        assert "100 times that on Earth" in found.text
    else:
        assert "reversed" in found.text
