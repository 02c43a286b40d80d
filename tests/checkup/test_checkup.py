"""What a checkup says of sound, short and spoiled data."""

import dataclasses
import json

import numpy as np
import pytest

from oed.checkup.checkup import check_dataset, checkup_record
from oed.checkup.completion import recorded_motion
from oed.checkup.finding import Checkup, Finding, multiple, share
from oed.checkup.motion_findings import coverage_finding
from oed.design.default_problem import ProblemSettings, default_problem
from oed.design.prior_experiments import prior_information
from oed.dynamics.models import build_model
from oed.experiment.preparation.settings import choose_settings
from oed.report.json_file import write_json
from tests.checkup.arm import changed, data_set


@pytest.fixture(scope="module")
def sound():
    return data_set(np.random.default_rng(51))


def check(dataset):
    model = build_model("rotor", dataset.robot, sign_width=0.02)
    return check_dataset(dataset, model, choose_settings(dataset.recordings))


def on(checkup, topic):
    return next(f for f in checkup.findings if f.topic == topic)


def test_sound_data_have_nothing_red(sound):
    found = check(sound)
    assert found.cause is None
    assert found.level != "red"
    topics = {
        "units and signs", "prediction", "parameters", "signs of parameters", "what moved", "ranges",
        "standstill", "rate and gaps", "noise and usable band", "repetitions", "saturation", "values",
        "gravity", "clipping", "held-out recordings", "time of the torque",
    }  # fmt: skip
    assert {f.topic for f in found.findings} == topics
    assert on(found, "prediction").level == "green"
    assert on(found, "rate and gaps").rows[0]["rate [Hz]"] == pytest.approx(200.0)


def test_a_joint_that_hardly_moved_for_estimation_is_told():
    found = check(data_set(np.random.default_rng(52), reach=(1.0, 1.0, 0.02)))
    moved = on(found, "what moved")
    assert moved.level == "amber"
    assert "elbow moves by" in moved.text
    assert "base moves by" not in moved.text


@pytest.mark.parametrize("role", ["validation", "test"])
def test_a_joint_that_stands_still_where_it_should_be_checked_is_told(sound, role):
    fitted, held = sound.recordings
    q = held.q.copy()
    q[:, 2] = q[0, 2] + 1e-5 * np.sin(held.t)  # as an encoder at rest
    standing = dataclasses.replace(held, name="standing", role=role, q=q)
    told = coverage_finding(dataclasses.replace(sound, recordings=(fitted, standing)))
    assert told.level == "amber"
    assert f"stands still: elbow in {role};" in told.text
    also = dataclasses.replace(held, role=role)
    told = coverage_finding(dataclasses.replace(sound, recordings=(fitted, standing, also)))
    assert told.level == "green"


def test_no_held_out_recording_is_told(sound):
    found = check(dataclasses.replace(sound, recordings=sound.estimation))
    assert "no recording is held out" in on(found, "what moved").text


def test_reversed_torques_are_red_though_no_estimate_can_be_made(sound):
    found = check(changed(sound, tau=lambda tau: -tau))
    assert found.cause is not None
    assert found.cause.kind == "sign"
    assert found.level == "red"
    assert "all torques have the opposite sign" in found.notes[0]
    assert "no estimate can be made" in on(found, "prediction").text


def test_pauses_and_gaps_are_told(sound):
    recording = sound.recordings[0]
    kept = (recording.t < 8.0) | (recording.t > 10.0)
    parts = {field: getattr(recording, field)[kept] for field in ("t", "q", "tau")}
    cut = dataclasses.replace(recording, **parts)
    found = check(dataclasses.replace(sound, recordings=(cut, sound.recordings[1])))
    rate = on(found, "rate and gaps")
    assert rate.level == "amber"
    assert "1 gap(s)" in rate.text


def test_a_drive_at_its_limit_is_told(sound):
    largest = np.abs(sound.recordings[0].tau).max(axis=0)
    limit = np.array([np.inf, 0.6 * largest[1], np.inf])
    limits = sound.robot.limits.with_(torque=np.column_stack([-limit, limit]))
    clipped = changed(sound, tau=lambda tau: np.clip(tau, -limit, limit))
    found = check(dataclasses.replace(clipped, robot=sound.robot.with_limits(limits)))
    saturation = on(found, "saturation")
    assert saturation.level == "amber"
    assert "shoulder" in saturation.text
    assert "base" not in saturation.text


def test_torques_that_would_be_within_the_limits_in_kilonewton_metres_are_told(sound):
    largest = max(np.abs(recording.tau).max() for recording in sound.recordings)
    bound = np.full((3, 1), 1.5 * largest)
    limits = sound.robot.limits.with_(torque=np.hstack([-bound, bound]))
    limited = dataclasses.replace(sound, robot=sound.robot.with_limits(limits))
    assert on(check(limited), "saturation").level == "green"
    saturation = on(check(changed(limited, tau=lambda tau: tau / 1000)), "saturation")
    assert saturation.level == "amber"
    assert "kN m" in saturation.text


def test_positions_beyond_the_limits_are_told(sound):
    narrow = np.tile([-0.2, 0.2], (3, 1))
    robot = sound.robot.with_limits(sound.robot.limits.with_(position=narrow))
    assert on(check(dataclasses.replace(sound, robot=robot)), "ranges").level == "amber"


def test_the_record_is_plain_json(sound, tmp_path):
    found = check(sound)
    write_json(tmp_path / "check.json", checkup_record(found))
    record = json.loads((tmp_path / "check.json").read_text())
    assert record["level"] == found.level
    assert [f["topic"] for f in record["findings"]] == [f.topic for f in found.findings]


def test_what_is_recorded_is_a_prior_of_a_design(sound, tmp_path):
    write_json(tmp_path / "motion.json", recorded_motion(sound, choose_settings(sound.recordings)))
    model = build_model("standard", sound.robot)
    problem = default_problem(model, ProblemSettings(instants=20)).problem
    information = prior_information([tmp_path / "motion.json"], problem)
    assert np.linalg.eigvalsh(information).min() > 0
    other = dataclasses.replace(
        sound.robot,
        joints=tuple(dataclasses.replace(j, name=f"x{j.name}") for j in sound.robot.joints),
    )
    others = default_problem(build_model("standard", other), ProblemSettings(instants=20)).problem
    with pytest.raises(ValueError, match="it moves"):
        prior_information([tmp_path / "motion.json"], others)


def test_notes_are_the_findings_that_cost_the_costliest_first():
    findings = (
        Finding("a", "green", "fine"),
        Finding("b", "amber", "dear", "do this"),
        Finding("c", "red", "wrong"),
    )
    assert Checkup("x", findings).notes == ("wrong", "dear; do this")
    assert Checkup("x", findings).level == "red"


def test_an_error_beyond_the_torque_is_no_percentage():
    assert share(0.0123) == "1.2 % of the torque"
    assert share(1.2) == "1.2 times the torque"
    assert multiple(11.63) == "11.6 times"
