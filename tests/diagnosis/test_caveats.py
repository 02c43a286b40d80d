"""What is said where a model or a name cannot be right."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from oed.diagnosis.evidence.caveats import caveats
from oed.diagnosis.evidence.estimates import Estimated
from oed.diagnosis.evidence.proof import RoleProof
from oed.diagnosis.evidence.verdict import FoundEffect
from oed.robot.builtin import imi_scara
from tests.diagnosis.arm import data_set
from tests.diagnosis.shop import shop_of, trial_of

UPRIGHT = imi_scara().with_gravity(np.array([0.0, 0.0, -9.81]))


def _proof(before, role="estimation"):
    ones = np.ones(2)
    wide = np.ones((2, 2))
    return RoleProof(role, ones, np.array(before), np.array(before), ones, wide, wide, wide)


@cache
def _trial():
    return trial_of(shop_of(data_set(1, repetitions=1)), "gravity_direction", None)


def _tilt(*angles):
    parameters = tuple(Estimated(f"tilt_{k + 1}", a, 0.01, "rad") for k, a in enumerate(angles))
    return FoundEffect("gravity_direction", None, parameters, 1e-9, 0.5, (), _trial())


def test_of_a_model_that_explains_its_torque_nothing_is_said():
    assert caveats((), [_proof([0.3, 0.89])], UPRIGHT) == ()


def test_a_model_that_explains_nothing_is_named_with_its_joint():
    (line,) = caveats((), [_proof([0.3, 0.95]), _proof([2.0, 2.0], "test")], UPRIGHT)
    # A share of 1 - 0.95^2 of the variance.
    assert line.startswith(f"{UPRIGHT.joint_names[1]}: the base model explains 10%")


@pytest.mark.parametrize(("angles", "is_doubted"), [((0.05, -0.02), False), ((0.3, -0.5), True)])
def test_a_tilt_beyond_what_mountings_err_by_is_doubted(angles, is_doubted):
    lines = caveats([_tilt(*angles)], [_proof([0.1, 0.1])], UPRIGHT)
    assert len(lines) == is_doubted
    if is_doubted:
        assert f"{np.rad2deg(np.hypot(*angles)):.0f} degrees" in lines[0]


def test_other_names_are_none_of_a_tilts():
    other = dataclasses.replace(_tilt(1.0), name="encoder_eccentricity")
    assert caveats([other], [_proof([0.1, 0.1])], UPRIGHT) == ()


def test_a_tilt_of_an_arm_that_is_declared_weightless_is_where_gravity_points():
    weightless = UPRIGHT.with_gravity(np.zeros(3))
    (line,) = caveats([_tilt(0.0, -1.46)], [_proof([0.1, 0.1])], weightless)
    assert "declared to be zero" in line
