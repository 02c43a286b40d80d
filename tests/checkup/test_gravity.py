"""Gravity declared with a wrong sign or in another unit is found with what should stand there."""

import dataclasses

import numpy as np
import pytest

from oed.checkup.checkup import check_dataset
from oed.checkup.gravity import gravity_finding
from oed.checkup.search import find_cause
from oed.dynamics.models import build_model
from oed.experiment.preparation.settings import choose_settings
from oed.experiment.read_dataset import read_dataset
from tests.checkup import hanging_arm
from tests.checkup.arm import with_robot
from tests.checkup.simulated_arm import dataset, model_of, processed, recorded
from tests.paths import SHARED_CASES, needs_shared_cases


def cause(data):
    found = find_cause(data, model_of(data.robot), processed(data)).cause
    assert found is not None
    return found


def test_the_true_gravity_is_left_alone():
    data = dataset()
    assert find_cause(data, model_of(data.robot), processed(data)).cause is None
    assert gravity_finding(dataset()).level == "green"


@pytest.mark.parametrize(
    "wrong", [(0.0, 0.0, 9.81), (0.0, 0.0, -981.0), (0.0, 0.0, 981.0), (0.0, 5.886, 7.848)]
)
def test_a_wrong_direction_and_a_wrong_unit_are_told_with_the_right_value(wrong):
    found = cause(dataset(gravity=wrong))
    assert found.kind == "gravity"
    assert found.remedy == "declare gravity = [0, 0, -9.81]"


def test_a_reversed_gravity_of_a_tilted_base_is_told_with_the_right_value():
    recordings = tuple(
        recorded(seed, role, role, gravity=(0.0, 5.886, -7.848))
        for seed, role in ((1, "estimation"), (2, "validation"))
    )
    found = cause(dataset(recordings=recordings, gravity=(0.0, -5.886, 7.848)))
    assert found.remedy == "declare gravity = [0, 5.886, -7.848]"


def test_of_directions_that_explain_one_link_alike_none_is_named():
    """Declared along its axis: any direction across it would do, with the link's mass elsewhere."""
    data = hanging_arm.data_set(1, links=1)
    turned = dataclasses.replace(data, robot=data.robot.with_gravity(np.array([9.81, 0.0, 0.0])))
    found = find_cause(turned, model_of(turned.robot), processed(turned))
    assert found.as_logged.relative[0] > 0.15
    assert found.cause is None


def test_a_size_that_is_nowhere_on_earth_is_told():
    found = gravity_finding(dataset(gravity=(0.0, 0.0, -981.0)))
    assert found.level == "amber"
    assert "100 times that on Earth" in found.text


def med7():
    """Poorly excited: a bad fit, which hardly anything repairs."""
    return read_dataset(SHARED_CASES / "feasible_no_solver_med7")


def checked(data):
    return check_dataset(
        data, build_model("standard", data.robot), choose_settings(data.recordings)
    )


def gravity_of(checkup):
    return next(f for f in checkup.findings if f.topic == "gravity")


@needs_shared_cases
def test_what_only_makes_a_bad_fit_less_bad_is_no_reversed_gravity():
    data = med7()
    flip = np.array([1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0])
    logs = tuple(dataclasses.replace(r, tau=r.tau * flip) for r in data.recordings)
    assert gravity_of(checked(dataclasses.replace(data, recordings=logs))).level == "green"


@needs_shared_cases
def test_gravity_in_another_unit_does_not_pass_for_a_unit_of_the_torques():
    """Beside rotors' inertias only coupling tells its size, and here hardly any is excited."""
    data = med7()
    found = checked(with_robot(data, data.robot.with_gravity(100 * data.robot.gravity)))
    assert found.cause is None
    gravity = gravity_of(found)
    assert gravity.level != "green"
    assert "100 times that on Earth" in gravity.text
