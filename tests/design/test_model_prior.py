"""A design for a found model has that model's columns, and excites what the model leaves in doubt."""

import dataclasses

import numpy as np
import pytest

from oed.design.default_limits import with_default_limits
from oed.design.default_problem import ProblemSettings, default_problem
from oed.design.known_arm import KnownTorqueModel
from oed.design.model_prior import (
    completing,
    for_design,
    known_information,
    not_designed_for,
)
from oed.design.optimisers.interior_point import optimise
from oed.design.optimisers.result import Budget
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import random_motion
from oed.dynamics.torque_model import TorqueModel
from tests.export.every_effect import EFFECTS, model_with

SETTINGS = ProblemSettings(instants=60, torque=False)
# Columns that change from instant to instant by what was before, or by what no motion chooses.
NEVER = {"presliding_hysteresis", "thermal_drift", "payload_change"}
MEASURED = {"backlash", "torque_gain", "time_delay", "filter_lag", "joint_elasticity"}
MEASURED |= {"encoder_eccentricity"}


def known_of(*names, forms=False):
    model, _ = model_with(*names, forms=forms, duration=0.2)
    robot = with_default_limits(model.robot)[0]
    whole = model.torque_model.with_robot(robot)
    assert model.covariance is not None
    return KnownTorqueModel(whole, model.parameters, model.covariance)


@pytest.mark.parametrize("name", EFFECTS)
def test_columns_are_those_of_the_torque_model_or_the_effect_is_named(name):
    whole = known_of(name)
    known = for_design(whole)
    named = {left.name for left in not_designed_for(whole.torque_model)}
    assert named == ({name} if name in NEVER | MEASURED else set())
    base = base_parameters(known.torque_model)
    problem = default_problem(known.torque_model, SETTINGS).problem
    problem = dataclasses.replace(completing(problem, known), native=False)
    motion = random_motion(problem.model.robot, 40, np.random.default_rng(1))
    arm = dataclasses.replace(whole.torque_model, measurement=())
    kept = [
        k
        for k, parameter in enumerate(arm.parameters)
        if parameter.name in {p.name for p in known.torque_model.parameters}
    ]
    truth = arm.columns(motion)[..., kept][..., base.columns]
    compiled = problem.regressor
    assert compiled.dense(compiled.entries(motion)) == pytest.approx(truth, abs=1e-12)
    assert (name in NEVER) == (len(kept) < len(arm.parameters))


def test_terms_without_physics_stay_as_they_were_found():
    whole = known_of(forms=True)
    reasons = {left.reason for left in not_designed_for(whole.torque_model)}
    assert "it names no physics: it stays as it was found" in reasons
    assert all(effect.has_physics for effect in for_design(whole).torque_model.effects)


def test_information_is_what_the_covariance_was_made_of():
    model = TorqueModel.standard(known_of().torque_model.robot)
    base = base_parameters(model)
    rows = np.random.default_rng(2).normal(size=(50, len(base))) * np.logspace(-2, 2, len(base))
    covariance = np.zeros((len(model.parameters),) * 2)
    covariance[np.ix_(base.columns, base.columns)] = np.linalg.inv(rows.T @ rows)
    information = known_information(base, covariance)
    assert information == pytest.approx(rows.T @ rows, rel=1e-6)
    # Of a parameter that was not estimated nothing is known.
    covariance[base.columns[3]] = covariance[:, base.columns[3]] = 0.0
    information = known_information(base, covariance)
    assert not information[3].any()
    # The others' is what is left when it is integrated out.
    rest = np.delete(np.arange(len(base)), 3)
    inverse = np.linalg.inv(rows.T @ rows)[np.ix_(rest, rest)]
    assert information[np.ix_(rest, rest)] == pytest.approx(np.linalg.inv(inverse), rel=1e-6)


@pytest.mark.parametrize(("doubtful", "share"), [("spring_2", 0.3), ("my_2", 0.8)])
def test_what_is_in_doubt_becomes_better_known_than_by_a_motion_for_the_same_terms(doubtful, share):
    whole = known_of("stribeck", "joint_spring")
    names = [p.name for p in whole.torque_model.parameters]
    std = 1e-4 * np.ones(len(names))
    std[names.index(doubtful)] = 100.0
    known = KnownTorqueModel(whole.torque_model, whole.parameters, np.diag(std**2))
    with_model = completing(default_problem(known.torque_model, SETTINGS).problem, known)
    without = default_problem(known.torque_model, SETTINGS).problem
    prior = np.linalg.inv((with_model.base.regrouping * std**2) @ with_model.base.regrouping.T)
    place = list(with_model.base.names).index(doubtful)

    def variance(problem):
        found = optimise(problem, Budget(evaluations=150), np.random.default_rng(0))
        motion = problem.trajectory.motion(found.z, problem.instants)
        # By the model's own columns: rows in units of the noise, beside what was known.
        rows = with_model.base.reduce(whole.torque_model.columns(motion))
        assert with_model.covariance is not None
        rows = (rows / np.sqrt(with_model.covariance)[:, None]).reshape(-1, len(with_model.base))
        return np.linalg.inv(prior + rows.T @ rows)[place, place]

    assert variance(with_model) < share * variance(without)
