"""A joint's torque that is any multiple of what the others need is named, and where no fit tells it that is said."""

import dataclasses

import numpy as np
import pytest

from oed.checkup.fit_findings import cause_finding
from oed.experiment.drive import Drive
from tests.checkup.arm import changed, data_set
from tests.checkup.test_cause import search, times


@pytest.fixture(scope="module")
def sound():
    return data_set(np.random.default_rng(41))


@pytest.mark.parametrize("factor", [1 / 32, 0.5, 7.0])
@pytest.mark.parametrize("joint", [1, 2])
def test_any_factor_of_one_joint_is_named_with_its_size(sound, joint, factor):
    factors = np.ones(3)
    factors[joint] = factor
    found = search(changed(sound, tau=times(*factors))).cause
    assert found.kind == "factor"
    told = float(found.text.split(" is ")[1].split(" times")[0])
    assert told == pytest.approx(factor, rel=0.1)
    assert f"(tau_{joint + 1})" in found.text


def test_factors_of_two_joints_are_not_guessed(sound):
    assert search(changed(sound, tau=times(0.1, 1.0, 5.0))).cause is None


def test_a_gear_that_explains_it_as_well_is_said_in_its_place(sound):
    spoiled = changed(sound, tau=times(1.0, 1 / 98, 1.0))
    found = search(dataclasses.replace(spoiled, drive=Drive(gear_ratio=np.full(3, 100.0)))).cause
    assert found.kind == "scale"


def test_the_scale_of_a_joint_that_the_others_do_not_feel_is_not_told(sound):
    """A shoulder and an elbow at rest leave the base alone with its own inertia, of whatever size."""
    still = changed(sound, q=lambda q: q * np.array([1.0, 0.0, 0.0]))
    alone = changed(still, tau=lambda tau: np.column_stack([tau[:, 0], 0 * tau[:, 1:]]))
    found = search(alone)
    assert 0 in found.untold
    assert search(sound).untold == ()
    assert "ten times or a tenth of the torque of " in cause_finding(alone, found).text
    assert "ten times" not in cause_finding(sound, search(sound)).text


def test_a_drive_that_does_not_feel_the_links_is_not_taken_for_one_in_another_unit(sound):
    """A spindle that holds itself: its torque fits beside the others once it outweighs none of them."""
    rng = np.random.default_rng(5)
    held = []
    for recording in sound.recordings:
        speed = np.gradient(recording.q[:, 1], recording.t)
        tau = recording.tau.copy()
        tau[:, 1] = 90.0 + 12.0 * speed + 0.3 * rng.standard_normal(len(speed))
        held.append(dataclasses.replace(recording, tau=tau))
    found = search(dataclasses.replace(sound, recordings=tuple(held)))
    assert found.cause is None
    assert 1 in found.untold
