"""Promises of a diagnosis as a whole, at a size that a test can pay."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set, stribeck

FAST = dataclasses.replace(DiagnosisSettings(), surrogates=39, bootstrap=40, refined=4)


@cache
def diagnosis_of(kind, seed=0):
    cases = {
        "clean": {},
        "coloured": {"colour": 0.03},
        "steps": {"step": 1e-4},
        "stribeck": {"extra": stribeck(1.0)},
        "foreign": {"extra": lambda q, dq, ddq: np.stack([q[:, 1] * dq[:, 0], 0 * q[:, 0]], 1)},
    }
    dataset = data_set(seed, **cases[kind])
    return diagnose(dataset, TorqueModel.standard(dataset.robot), FAST)


@pytest.mark.parametrize("kind", ["clean", "coloured", "steps"])
def test_nothing_is_named_where_nothing_is_missing(kind):
    found = diagnosis_of(kind)
    assert found.effects == ()
    assert found.verdict == "nothing found"


def test_lack_of_fit_is_not_seen_where_there_is_none():
    found = diagnosis_of("coloured")
    assert found.lack_before.ratio.max() < 1.2


def test_names_the_effect_and_its_joint_although_its_formula_differs():
    found = diagnosis_of("stribeck")
    assert [(e.name, e.joint) for e in found.effects] == [("stribeck", 0)]
    value = {p.name: p for p in found.effects[0].parameters}["Fs_1"]
    assert abs(value.value - 1.0) < max(3 * value.std, 0.2)
    assert found.lack_before.ratio[0] > 1.2


def test_error_reaches_the_floor_on_recordings_that_were_sealed():
    found = diagnosis_of("stribeck")
    test = next(p for p in found.proof if p.role == "test")
    assert test.after[0] < test.before[0]
    assert test.after[0] < 1.15 * found.noise_floor[0]


@pytest.mark.parametrize("kind", ["clean", "coloured", "steps", "stribeck", "foreign"])
def test_never_worse_on_validation(kind):
    found = diagnosis_of(kind)
    validation = next(p for p in found.proof if p.role == "validation")
    assert np.mean((validation.after / validation.before) ** 2) <= 1.0


def test_claims_no_name_for_what_the_catalogue_lacks():
    found = diagnosis_of("foreign")
    assert found.effects == ()
    assert found.verdict == "unexplained"
    assert any(u.joint == 0 and "q_2" in u.depends_on for u in found.unexplained)


def test_augmented_model_is_an_ordinary_torque_model():
    found = diagnosis_of("stribeck")
    motion = found.shop.full.rows.prepared[0].motion[:50]
    torque = found.after.model.torque(found.after.parameters, motion)
    assert torque.shape == (50, 2)
    assert len(found.after.model.parameters) == len(found.after.parameters)
