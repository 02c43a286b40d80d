"""`oed calibrate`: what the model lacks does not end up in masses, and one page links everything."""

import importlib
import re

import numpy as np
import pytest

from oed.commands.rollouts import BASE_OF_BODIES
from oed.experiment.write_dataset import write_dataset
from oed.export.model_file import load_model, write_model
from oed.report.calibrate_page import calibrate_page
from oed.report.json_file import read_json
from oed.report.page import render_page
from oed.report.provenance import Provenance
from oed.report.study_files import CALIBRATE
from oed.robot import imi_scara, load_robot
from tests.diagnosis.arm import NOISE, data_set
from tests.dynamics.effects.arms import panda, smooth_motion
from tests.experiment.importing.laboratory_logs import bag_mcap, simulate, write_urdf
from tests.export.every_effect import model_with
from tests.running import oed

SPRING, OFFSET = 1.5, 0.5


def pull(q, dq, ddq):
    """A cable at the second joint, which no standard model has."""
    result = np.zeros_like(q)
    result[:, 1] = SPRING * q[:, 1] + OFFSET
    return result


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calibrate")
    write_dataset(data_set(52, extra=pull, repetitions=2), folder / "data")
    told = ("--model", "standard", "--smoke", "--quiet", "--to", "c", "--refine", "rollout")
    few = ("--candidates", "joint_spring", "torque_offset", "stribeck")
    assert oed("calibrate", folder / "data", "--out", folder / "out", *told, *few) == 0
    return folder / "out"


def test_one_page_links_everything(calibrated):
    page = (calibrated / "index.html").read_text(encoding="utf-8")
    linked = re.findall(r'<a href="([^"#]+)"', page)
    assert len(linked) >= 5
    assert all((calibrated / address).is_file() for address in linked)
    assert "joint_spring (joint 2)" in page


def test_bodies_are_estimated_beside_what_was_found(calibrated):
    model = load_model(calibrated / "feasible" / "model.json")
    assert model.is_feasible
    values = dict(
        zip((p.name for p in model.torque_model.parameters), model.parameters, strict=True)
    )
    assert values["spring_2"] == pytest.approx(SPRING, rel=0.1)
    # A plane shows no masses; the outer link's inertia and first moments it does.
    truth = dict(zip(imi_scara().parameter_names, imi_scara().parameters, strict=True))
    for name in ("Izz_2", "mx_2", "my_2"):
        assert values[name] == pytest.approx(truth[name], rel=0.05)


def test_what_has_no_name_is_said_in_words(calibrated):
    record = read_json(calibrated / "calibration.json")
    told = read_json(calibrated / "diagnosis" / "diagnosis.json")["unexplained"]
    assert record["without_name"] == [item["words"] for item in told]
    left = {**record, "unexplained": 1, "without_name": ["joint 1: friction that depends on time"]}
    provenance = Provenance.collect(CALIBRATE, seed=0)
    page = render_page(calibrate_page(left, provenance))
    assert "Without a name: joint 1: friction that depends on time." in page


def test_the_record_says_what_came_out(calibrated):
    record = read_json(calibrated / "calibration.json")
    assert record["effects"] == [{"name": "joint_spring", "joint": 1}]
    assert record["exports"] == {"c": ["oed_model.c", "oed_model.h"]}
    rms = record["rms"]
    assert rms["after"]["test"][1] < rms["before"]["test"][1] / 2


def test_a_simulation_with_what_was_found_moves_like_the_arm(calibrated):
    models = read_json(calibrated / "calibration.json")["rollout"]["models"]
    base, augmented, feasible = (
        models[name]["flange_mm"][-1] for name in (BASE_OF_BODIES, "augmented", "feasible")
    )
    assert augmented < base
    assert feasible < base
    page = (calibrated / "index.html").read_text(encoding="utf-8")
    assert "Whether a simulation moves like the arm" in page
    # Least squares explains the cable by an inertia below zero.
    assert models["base"]["flange_mm"] is None
    assert models["base"]["not_simulated"].startswith("the mass matrix has the eigenvalue -")
    assert "Not simulated, base: the mass matrix" in page


def test_a_refined_model_is_kept_only_if_nothing_held_out_gets_worse(calibrated):
    record = read_json(calibrated / "calibration.json")["refinement"]
    assert record["directions"] > 0
    judge = next(row for row in record["errors"] if row["role"] == "validation")
    pairs = zip(judge["flange_mm_before"], judge["flange_mm_after"], strict=True)
    better = judge["torque_ratio"] <= 1 and all(new <= old for old, new in pairs)
    assert record["accepted"] == better
    assert (calibrated / "refined" / "model.json").is_file() == better
    page = (calibrated / "index.html").read_text(encoding="utf-8")
    assert "Refined by rollout" in page
    assert ('href="refined/model.json"' in page) == better


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--to", "plan9"), "no form 'plan9'"),
        (("--to",), "--to: name at least one form"),
        (("--candidates", "gremlins"), "no effect 'gremlins'"),
        (("--rate", "0"), "--rate 0 is no number from 1"),
        (("--budget", "-1"), "--budget -1 is no number from 0"),
    ],
)
def test_what_a_later_step_cannot_do_is_refused_before_the_work(tmp_path, capsys, options, line):
    assert oed("calibrate", tmp_path, "--out", tmp_path / "o", *options) == 2
    assert line in capsys.readouterr().err
    assert not (tmp_path / "o").exists()


def test_least_squares_finds_the_spring_again(calibrated, tmp_path):
    start = calibrated / "diagnosis" / "model.json"
    assert (
        oed("identify", calibrated.parent / "data", "--out", tmp_path, "--model", start, "--quiet")
        == 0
    )
    model = load_model(tmp_path / "model.json")
    values = dict(
        zip((p.name for p in model.torque_model.parameters), model.parameters, strict=True)
    )
    assert values["spring_2"] == pytest.approx(SPRING, rel=0.1)
    again = load_model(start)
    motion = smooth_motion(model.robot, 2.0)
    differ = again.torque(motion.q, motion.dq, motion.ddq) - model.torque(
        motion.q, motion.dq, motion.ddq
    )
    assert np.sqrt(np.mean(differ**2, axis=0)) == pytest.approx(0, abs=NOISE.max() / 5)
    assert [s.name for s in model.shapes[-1]] == [s.name for s in again.shapes[-1]]


def test_a_second_round_finds_nothing_more(calibrated, tmp_path):
    start = calibrated / "diagnosis" / "model.json"
    told = ("--model", start, "--smoke", "--quiet")
    few = ("--candidates", "joint_spring", "torque_offset", "stribeck")
    data = calibrated.parent / "data"
    assert oed("diagnose", data, "--out", tmp_path, *told, *few) == 0
    second = read_json(tmp_path / "diagnosis.json")
    assert second["effects"] == []
    first = read_json(calibrated / "diagnosis" / "diagnosis.json")["rms"]["after"]
    for role, error in second["rms"]["before"].items():
        assert error == pytest.approx(first[role], rel=0.03)


def test_a_model_of_another_arm_is_refused(calibrated, tmp_path, capsys):
    other, _ = model_with(robot=panda(), duration=0.1)
    path = write_model(other, tmp_path / "other.json")
    assert (
        oed("identify", calibrated.parent / "data", "--out", tmp_path / "o", "--model", path) == 2
    )
    assert "its joints are panda_joint1" in capsys.readouterr().err
    assert (
        oed("identify", calibrated.parent / "data", "--out", tmp_path / "o", "--model", "rotr") == 2
    )
    told = capsys.readouterr().err
    assert "--model rotr: neither one of standard, offset, rotor nor a model.json" in told


@pytest.mark.parametrize(
    ("command", "told"),
    [("calibrate", "the steps that were done are kept"), ("identify", "nothing was written")],
)
def test_an_interrupt_says_what_is_left(tmp_path, capsys, monkeypatch, command, told):
    def interrupted(_):
        raise KeyboardInterrupt

    module = importlib.import_module(f"oed.commands.{command}")
    monkeypatch.setattr(module, "run", interrupted)
    assert oed(command, tmp_path, "--out", tmp_path / "o") == 130
    assert capsys.readouterr().err == f"\noed {command}: interrupted: {told}\n"


def test_a_warning_is_said_once(tmp_path, capsys):
    arm = write_urdf(tmp_path / "arm.urdf")
    log = bag_mcap(simulate(load_robot(arm), rows=600), tmp_path)
    # A link that the file has for a twentieth of what it is.
    arm.write_text(arm.read_text().replace('mass value="3.0"', 'mass value="0.15"'))
    told = ("--model", "standard", "--smoke", "--quiet", "--to", "c", "--candidates", "stribeck")
    assert oed("calibrate", log, "--robot", arm, "--out", tmp_path / "out", *told) == 0
    warnings = read_json(tmp_path / "out" / "calibration.json")["warnings"]
    said = capsys.readouterr().out
    assert warnings
    for words in warnings:
        assert said.count(words) == 1
