"""Gains that Pinocchio's torques were divided by are found again from a known load."""

import dataclasses

import numpy as np
import pytest

from oed.estimation.load.current_equations import CurrentEquations, KnownLoad
from oed.estimation.load.gains import estimate_gains
from oed.estimation.load.loaded_model import LoadedModel
from oed.robot.attached_frame import find_frame
from oed.robot.inertia import pseudo_inertia
from tests.estimation.load.carrying_arm import CENTRE, FRAME, MASS, MODEL, ROBOT, recording

GAINS = np.array([14.0, 12.5, 11.0, 9.0, 8.0, 8.5])  # [N m/A]
BARE = LoadedModel.bare(MODEL, FRAME)


def in_amperes(processed):
    return dataclasses.replace(processed, tau=processed.tau / GAINS)


@pytest.fixture(scope="module")
def currents():
    rng = np.random.default_rng(11)
    return [in_amperes(recording(rng, 20.0, is_loaded=x, noise=0.5)) for x in (False, True)]


@pytest.fixture(scope="module")
def equations(currents):
    bare, loaded = currents
    return CurrentEquations.of(BARE, [bare], [[loaded]], [KnownLoad(MASS)])


@pytest.fixture(scope="module")
def found(equations):
    return estimate_gains(equations)


def test_a_known_mass_gives_every_gain_within_a_per_cent(found):
    told = [gain.value for gain in found.gains]
    assert told[1:5] == pytest.approx(GAINS[1:5], rel=0.01)
    # The first turns about the vertical and the last about the load: hardly more than inertia.
    assert told[::5] == pytest.approx(GAINS[::5], rel=0.03)
    held = [
        low <= k <= high
        for (low, high), k in zip([g.interval for g in found.gains], GAINS, strict=True)
    ]
    assert sum(held) >= 5
    assert found.reference is None


def test_every_body_can_exist_and_the_mass_is_the_given_one(found):
    for body in (*found.consistent.links, *found.consistent.loads):
        assert np.linalg.eigvalsh(pseudo_inertia(body))[0] > 0
    assert found.consistent.loads[0, 0] == pytest.approx(MASS)


def test_the_start_does_not_matter(currents, found):
    bare, loaded = currents
    light = ROBOT.with_parameters(ROBOT.parameters / 30)
    model = LoadedModel.bare(MODEL.with_robot(light), FRAME)
    again = estimate_gains(CurrentEquations.of(model, [bare], [[loaded]], [KnownLoad(MASS)]))
    assert [g.value for g in again.gains] == pytest.approx([g.value for g in found.gains], rel=2e-3)


def test_rows_are_the_slopes_of_the_current(equations):
    x = np.random.default_rng(0).normal(size=equations.size) * 0.1
    x[equations.places["beta"]] += 1.0
    rows, right = equations.linearised(x)
    modelled = equations.modelled(x)
    # The next estimate solves rows x' = right: a step along the slopes from what is modelled.
    assert right == pytest.approx(equations.current - modelled + (rows @ x).reshape(right.shape))
    for k in (0, equations.places["phi"].start, equations.places["mu"].start + 1, -3):
        step = np.zeros(len(x))
        step[k] = 1e-5
        slope = (equations.modelled(x + step) - equations.modelled(x - step)) / 2e-5
        assert rows[:, k] == pytest.approx(
            slope.reshape(-1), rel=1e-4, abs=1e-4 * np.abs(modelled).max()
        )


def test_without_a_mass_ratios_alone_are_told(currents):
    bare, loaded = currents
    found = estimate_gains(CurrentEquations.of(BARE, [bare], [[loaded]], [KnownLoad()]))
    unit = GAINS[ROBOT.joint_names.index(found.reference)]
    told = np.array([gain.value for gain in found.gains])
    assert told[1:] == pytest.approx(GAINS[1:] / unit, rel=0.02)


def test_stated_constants_are_corrected(currents, found):
    stated = np.full(6, 10.0)
    as_torques = [dataclasses.replace(r, tau=r.tau * stated) for r in currents]
    loads = [KnownLoad(MASS, CENTRE)]
    equations = CurrentEquations.of(BARE, as_torques[:1], [as_torques[1:]], loads)
    told = [gain.value for gain in estimate_gains(equations, stated).gains]
    assert told[1:5] == pytest.approx(GAINS[1:5], rel=0.01)


def test_joints_beyond_the_load_are_refused_by_name():
    rng = np.random.default_rng(1)
    model = LoadedModel.bare(MODEL, find_frame(ROBOT, "forearm_link"))
    bare, loaded = (
        in_amperes(recording(rng, 8.0, is_loaded=x, noise=20.0, at="forearm_link"))
        for x in (False, True)
    )
    found = estimate_gains(CurrentEquations.of(model, [bare], [[loaded]], [KnownLoad(MASS)]))
    refused = {gain.joint: gain.reason for gain in found.gains if gain.value is None}
    assert {"wrist_2_joint", "wrist_3_joint"} <= set(refused)
    assert "no load at this place is felt by this joint" in refused["wrist_3_joint"]
