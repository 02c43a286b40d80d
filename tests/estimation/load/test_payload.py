"""A body that Pinocchio welds to an arm is found again, whatever the arm is known from."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.models import build_model
from oed.errors import NoUsableResult
from oed.estimation.load.friction_change import friction_change
from oed.estimation.load.known_arm import FoundArm, KnownArm
from oed.estimation.load.loaded_model import LoadedModel
from oed.estimation.load.payload import estimate_payload, with_friction
from oed.estimation.load.undetermined import open_quantities
from oed.robot import load_robot
from oed.robot.attached_frame import find_frame
from tests.estimation.load.carrying_arm import (
    CENTRAL,
    CENTRE,
    COULOMB,
    FRAME,
    MASS,
    MODEL,
    ROBOT,
    VISCOUS,
    known_interval,
    recording,
)

TRUTH = np.array([MASS, *CENTRE, *CENTRAL[np.triu_indices(3)]])
BARE = LoadedModel.bare(MODEL, FRAME)


def values(payload):
    return np.array([quantity.value for quantity in payload.quantities])


def holds(payload, k):
    low, high = known_interval(payload.quantities[k])
    return low <= TRUTH[k] <= high


@pytest.fixture(scope="module")
def logs():
    rng = np.random.default_rng(2)
    return recording(rng, 24.0, is_loaded=False), recording(rng, 12.0, is_loaded=True)


@pytest.fixture(scope="module")
def weighed(logs):
    return estimate_payload(KnownArm.from_recordings(BARE, logs[:1]), logs[1:])


def test_a_body_is_found_exactly_where_nothing_is_noisy():
    rng = np.random.default_rng(0)
    bare, loaded = (recording(rng, 16.0, noise=0.0, is_loaded=x) for x in (False, True))
    found = estimate_payload(KnownArm.from_recordings(BARE, [bare]), [loaded])
    assert values(found)[:4] == pytest.approx(TRUTH[:4], abs=1e-3)
    assert values(found)[4:] == pytest.approx(TRUTH[4:], abs=3e-4)


def test_intervals_hold_the_body_and_are_narrow(weighed):
    assert sum(holds(weighed, k) for k in range(10)) >= 9
    low, high = weighed["mass"].interval
    assert 0.005 < high - low < 0.15
    assert all(weighed[axis].is_determined for axis in "xyz")


def test_the_body_can_exist_and_lies_within_its_intervals(weighed):
    assert weighed.margin > 0
    for quantity in weighed.quantities:
        low, high = quantity.interval
        assert low <= quantity.value <= high


def test_a_model_from_before_weighs_as_both_logs_do(logs, weighed):
    arm = weighed.arm
    columns, count = arm.model.base.columns, len(arm.model.base)
    parameters, covariance = np.zeros(len(MODEL.parameters)), np.zeros((len(MODEL.parameters),) * 2)
    parameters[columns] = arm.mean[:count]
    covariance[np.ix_(columns, columns)] = arm.covariance[:count, :count]
    before = FoundArm("model.json", MODEL, parameters, covariance)
    found = estimate_payload(KnownArm.from_model(FRAME, before, logs[1:]), logs[1:])
    assert found.arm.route == "model"
    std = np.sqrt(np.diag(weighed.linear.covariance))
    assert np.all(np.abs(found.linear.parameters - weighed.linear.parameters) < 2 * std)
    wider = np.sqrt(np.diag(found.linear.covariance)) / std
    assert np.all((wider > 0.75) & (wider < 2.5))


def test_the_robot_file_alone_weighs_roughly_and_says_so(logs, weighed):
    found = estimate_payload(KnownArm.from_file(BARE, logs[1:]), logs[1:])
    width, known = (np.ptp(known_interval(p["mass"])) for p in (found, weighed))
    assert holds(found, 0)
    assert width > 5 * known
    assert "robot file" in found.arm.words
    assert "wide" in found.arm.words


def test_placeholders_tell_no_arm_from_its_load(logs):
    plain = np.tile([1.0, 0, 0, 0, 1.0, 0, 0, 1.0, 0, 1.0], 6)
    robot = ROBOT.with_parameters(plain)
    bare = LoadedModel.bare(build_model("standard", robot), FRAME)
    with pytest.raises(NoUsableResult, match=r"placeholders.*--bare"):
        KnownArm.from_file(bare, logs[1:])


def test_friction_that_grows_with_the_load_does_not_pass_for_mass():
    rng = np.random.default_rng(5)
    bare, loaded = (recording(rng, 20.0, is_loaded=x, load_friction=0.12) for x in (False, True))
    found, without = (
        estimate_payload(KnownArm.from_recordings(model, [bare]), [loaded])
        for model in (BARE, LoadedModel.bare(MODEL, FRAME, has_load_friction=False))
    )
    told = with_friction(found, without).friction
    assert told is not None
    assert told.found == (0, 1, 2, 3, 4, 5)
    assert told.mu == pytest.approx(0.12, abs=0.03)
    assert holds(found, 0)
    assert told.mass_without is not None
    assert told.interval_without is not None
    assert abs(told.mass_without - MASS) > 3 * abs(found.mass - MASS)
    assert np.ptp(told.interval_without) > 3 * np.ptp(known_interval(found["mass"]))


@pytest.mark.parametrize("share", [0.15, 0.9])
def test_friction_of_another_day_does_not_pass_for_mass(share):
    rng = np.random.default_rng(7)
    bare, loaded = recording(rng, 20.0, is_loaded=False), recording(rng, 20.0, is_loaded=True)
    motion = loaded.motion
    colder = share * (COULOMB * np.tanh(motion.dq / 0.02) + VISCOUS * motion.dq)
    loaded = dataclasses.replace(loaded, tau=loaded.tau + colder)
    found = estimate_payload(KnownArm.from_recordings(BARE, [bare]), [loaded])
    assert holds(found, 0)
    assert found.mass == pytest.approx(MASS, rel=0.02)


def test_friction_may_change_by_as_much_torque_as_it_is(weighed):
    equations, model = weighed.equations, weighed.model
    mean = np.zeros(len(model.names))
    mean[: len(model.base)] = weighed.arm.mean[: len(model.base)]
    covariance = friction_change(equations, mean)
    columns = np.concatenate(equations.columns)
    names = [model.names[k] for k in np.flatnonzero(model.is_friction)]
    assert (
        np.flatnonzero(np.diag(covariance)).tolist() == np.flatnonzero(model.is_friction).tolist()
    )
    for joint in range(6):
        own = [model.names.index(f"{symbol}_{joint + 1}") for symbol in ("Fc", "Fv")]
        assert len(names) == 12
        curve = columns[:, joint, own]
        now = np.mean((curve @ mean[own]) ** 2)
        change = np.mean(np.einsum("kp,pq,kq->k", curve, covariance[np.ix_(own, own)], curve))
        assert change == pytest.approx(2 * now)  # two independent ways


def test_what_no_joint_feels_is_named():
    scara = load_robot("builtin:imi_scara")
    model = LoadedModel.bare(build_model("standard", scara), find_frame(scara)).loaded()
    assert [model.names[k] for k in range(model.load.start, model.load.stop)] == [
        "load_m",
        "load_mx",
        "load_my",
        "load_Izz",
    ]


def test_a_short_noisy_log_says_what_motion_would_tell(logs):
    arm = KnownArm.from_recordings(BARE, logs[:1])
    rng = np.random.default_rng(3)
    short = recording(rng, 3.0, is_loaded=True, noise=16.0)
    told = {each.name: each.remedy for each in open_quantities(estimate_payload(arm, [short]))}
    assert {"Ixx", "Iyy"} <= set(told)
    assert "mass" not in told
    assert "accelerations of joint" in told["Ixx"]
